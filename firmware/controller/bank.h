/* bank.h: the parameters that an image brings: those of the rules and terms, and the integral of the model's feedback. Copied number by
 * number: for a struct assignment compilers may call a library. */

#ifndef BANK_H
#define BANK_H

#include <stdint.h>

#include "linkage.h"
#include "model.h"

LINKAGE_BEGIN

typedef struct {
    model_bank_t rules;
    float half;  /* integral of the feedback, half of it a sample; 0 without feedback */
} bank_t;

#define BANK_WORDS (3u * MODEL_RULES + MODEL_WEIGHTS + 1u)

void hysgen_bank_copy(bank_t *to, const bank_t *from);

/* The parameters that drive a model, and the other way: in both of its banks. */
void hysgen_bank_take(bank_t *to, const model_t *from);
void hysgen_bank_drive(model_t *to, const bank_t *from);

/* Word i of the parameters, in the order of an image; and the other way. */
uint32_t hysgen_bank_word(bank_t *bank, uint32_t i);
void hysgen_bank_put(bank_t *bank, uint32_t i, uint32_t word);

/* Check word of all of them. */
uint32_t hysgen_bank_check(bank_t *bank);

LINKAGE_END

#endif
