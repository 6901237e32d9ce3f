#include "siphash.h"

typedef struct {
    uint32_t low;
    uint32_t high;
} siphash_word_t;

typedef struct {
    siphash_word_t v[4];
} siphash_t;

static void siphash_add(siphash_word_t *to, siphash_word_t x)
{
    const uint32_t low = to->low + x.low;

    to->high = to->high + x.high + (uint32_t)(low < x.low);
    to->low = low;
}

static void siphash_mix(siphash_word_t *to, siphash_word_t x)
{
    to->low ^= x.low;
    to->high ^= x.high;
}

/* x <<< count, 0 < count < 32 */
static siphash_word_t siphash_rotated(siphash_word_t x, uint32_t count)
{
    const uint32_t rest = 32u - count;
    const siphash_word_t turned = { (x.low << count) | (x.high >> rest), (x.high << count) | (x.low >> rest) };

    return turned;
}

/* x <<< 32 */
static siphash_word_t siphash_swapped(siphash_word_t x)
{
    const siphash_word_t turned = { x.high, x.low };

    return turned;
}

static void siphash_rounds(siphash_t *self, uint32_t count)
{
    siphash_word_t *v = self->v;

    for (uint32_t i = 0u; i < count; ++i) {
        siphash_add(&v[0], v[1]);
        siphash_add(&v[2], v[3]);
        v[1] = siphash_rotated(v[1], 13u);
        v[3] = siphash_rotated(v[3], 16u);
        siphash_mix(&v[1], v[0]);
        siphash_mix(&v[3], v[2]);
        v[0] = siphash_swapped(v[0]);
        siphash_add(&v[2], v[1]);
        siphash_add(&v[0], v[3]);
        v[1] = siphash_rotated(v[1], 17u);
        v[3] = siphash_rotated(v[3], 21u);
        siphash_mix(&v[1], v[2]);
        siphash_mix(&v[3], v[0]);
        v[2] = siphash_swapped(v[2]);
    }
}

static void siphash_take(siphash_t *self, siphash_word_t word)
{
    siphash_mix(&self->v[3], word);
    siphash_rounds(self, 2u);
    siphash_mix(&self->v[0], word);
}

/* Up to eight bytes as a word, the first in the low bits. */
static siphash_word_t siphash_word(const uint8_t *bytes, uint32_t count)
{
    siphash_word_t word = { 0u, 0u };

    for (uint32_t i = 0u; i < count; ++i) {
        const uint32_t byte = (uint32_t)bytes[i] << (8u * (i & 3u));

        if (i < 4u) {
            word.low |= byte;
        } else {
            word.high |= byte;
        }
    }
    return word;
}

void hysgen_siphash(const uint32_t key[4], const uint8_t *bytes, uint32_t count, uint32_t tag[2])
{
    const siphash_word_t first = { key[0], key[1] };
    const siphash_word_t second = { key[2], key[3] };
    const siphash_word_t done = { 0xFFu, 0u };
    const uint32_t whole = count & ~7u;
    siphash_t self = { {
        { 0x70736575u, 0x736F6D65u },
        { 0x6E646F6Du, 0x646F7261u },
        { 0x6E657261u, 0x6C796765u },
        { 0x79746573u, 0x74656462u },
    } };
    siphash_word_t last;

    siphash_mix(&self.v[0], first);
    siphash_mix(&self.v[1], second);
    siphash_mix(&self.v[2], first);
    siphash_mix(&self.v[3], second);
    for (uint32_t at = 0u; at < whole; at += 8u) {
        siphash_take(&self, siphash_word(&bytes[at], 8u));
    }
    last = siphash_word(&bytes[whole], count - whole);
    last.high |= (count & 0xFFu) << 24;
    siphash_take(&self, last);
    siphash_mix(&self.v[2], done);
    siphash_rounds(&self, 4u);
    tag[0] = self.v[0].low ^ self.v[1].low ^ self.v[2].low ^ self.v[3].low;
    tag[1] = self.v[0].high ^ self.v[1].high ^ self.v[2].high ^ self.v[3].high;
}
