#include "bank.h"

#include "bytes.h"
#include "number.h"

static void bank_copy_rules(model_bank_t *to, const model_bank_t *from)
{
    for (uint32_t l = 0u; l < MODEL_RULES; ++l) {
        to->slope[l] = from->slope[l];
        to->offset[l] = from->offset[l];
        to->gain[l] = from->gain[l];
    }
#ifdef MODEL_TERMS
    for (uint32_t j = 0u; j < MODEL_WEIGHTS; ++j) {
        to->weight[j] = from->weight[j];
    }
#endif
}

void hysgen_bank_copy(bank_t *to, const bank_t *from)
{
    bank_copy_rules(&to->rules, &from->rules);
    to->half = from->half;
}

void hysgen_bank_take(bank_t *to, const model_t *from)
{
    bank_copy_rules(&to->rules, &from->bank[from->active]);
#ifdef MODEL_LOOP_LIMIT_UM
    to->half = from->loop.half;
#else
    to->half = 0.0f;
#endif
}

void hysgen_bank_drive(model_t *to, const bank_t *from)
{
    bank_copy_rules(&to->bank[0], &from->rules);
    bank_copy_rules(&to->bank[1], &from->rules);
#ifdef MODEL_LOOP_LIMIT_UM
    to->loop.half = from->half;
#endif
}

/* Where word i stands. */
static float *bank_place(bank_t *bank, uint32_t i)
{
    float *place = &bank->half;

    if (i < MODEL_RULES) {
        place = &bank->rules.slope[i];
    } else if (i < 2u * MODEL_RULES) {
        place = &bank->rules.offset[i - MODEL_RULES];
    } else if (i < 3u * MODEL_RULES) {
        place = &bank->rules.gain[i - 2u * MODEL_RULES];
    } else {
#ifdef MODEL_TERMS
        if (i < 3u * MODEL_RULES + MODEL_WEIGHTS) {
            place = &bank->rules.weight[i - 3u * MODEL_RULES];
        }
#endif
    }
    return place;
}

void hysgen_bank_put(bank_t *bank, uint32_t i, uint32_t word)
{
    *bank_place(bank, i) = number_of(word);
}

uint32_t hysgen_bank_word(bank_t *bank, uint32_t i)
{
    return number_bits(*bank_place(bank, i));
}

uint32_t hysgen_bank_check(bank_t *bank)
{
    uint32_t check = 1u;

    for (uint32_t i = 0u; i < BANK_WORDS; ++i) {
        check = bytes_check(check, hysgen_bank_word(bank, i));
    }
    return check;
}
