#include "bank.h"

#include "bytes.h"
#include "number.h"

uint32_t hysgen_bank_check(const model_bank_t *bank)
{
    uint32_t check = 1u;

    for (uint32_t l = 0u; l < MODEL_RULES; ++l) {
        check = bytes_check(check, number_bits(bank->slope[l]));
    }
    for (uint32_t l = 0u; l < MODEL_RULES; ++l) {
        check = bytes_check(check, number_bits(bank->offset[l]));
    }
    for (uint32_t l = 0u; l < MODEL_RULES; ++l) {
        check = bytes_check(check, number_bits(bank->gain[l]));
    }
#ifdef MODEL_TERMS
    for (uint32_t j = 0u; j < MODEL_WEIGHTS; ++j) {
        check = bytes_check(check, number_bits(bank->weight[j]));
    }
#endif
    return check;
}
