/* bank.h: copying and checking a model's parameters. Number by number: for a struct assignment compilers may call a library. */

#ifndef BANK_H
#define BANK_H

#include <stdint.h>

#include "linkage.h"
#include "model.h"

LINKAGE_BEGIN

static inline void bank_copy(model_bank_t *to, const model_bank_t *from)
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

#define BANK_WORDS (3u * MODEL_RULES + MODEL_WEIGHTS)

/* Word i of the parameters, in the order of an image. */
uint32_t hysgen_bank_word(const model_bank_t *bank, uint32_t i);

/* Check word of all of them. */
uint32_t hysgen_bank_check(const model_bank_t *bank);

LINKAGE_END

#endif
