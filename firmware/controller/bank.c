#include "bank.h"

#include "bytes.h"
#include "number.h"

uint32_t hysgen_bank_word(const model_bank_t *bank, uint32_t i)
{
    float number = 0.0f;

    if (i < MODEL_RULES) {
        number = bank->slope[i];
    } else if (i < 2u * MODEL_RULES) {
        number = bank->offset[i - MODEL_RULES];
    } else if (i < 3u * MODEL_RULES) {
        number = bank->gain[i - 2u * MODEL_RULES];
    } else {
#ifdef MODEL_TERMS
        number = bank->weight[i - 3u * MODEL_RULES];
#endif
    }
    return number_bits(number);
}

uint32_t hysgen_bank_check(const model_bank_t *bank)
{
    uint32_t check = 1u;

    for (uint32_t i = 0u; i < BANK_WORDS; ++i) {
        check = bytes_check(check, hysgen_bank_word(bank, i));
    }
    return check;
}
