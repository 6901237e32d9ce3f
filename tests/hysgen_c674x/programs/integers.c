/* What firmware does besides arithmetic: hashing, bytes and halfwords, conversions, library calls, data-driven loops. */
#include <stdint.h>

uint32_t hash(const uint8_t *bytes, uint32_t count);
int32_t sum_of_halves(const int16_t *values, uint32_t count);
int32_t converted(float x);
float divided(float a, float b);
uint32_t collatz(uint32_t n);
uint32_t sorted(int32_t *values);

/* FNV-1a */
uint32_t hash(const uint8_t *bytes, uint32_t count)
{
    uint32_t h = 2166136261u, i;
    for (i = 0; i < count; i++)
        h = (h ^ bytes[i]) * 16777619u;
    return h;
}

int32_t sum_of_halves(const int16_t *values, uint32_t count)
{
    int32_t sum = 0;
    uint32_t i;
    for (i = 0; i < count; i++)
        sum += values[i] * (int32_t)(i + 1);
    return sum;
}

int32_t converted(float x)
{
    return (int32_t)(x * 65536.0f) + (int32_t)x * 3;
}

float divided(float a, float b)
{
    return a / b;
}

uint32_t collatz(uint32_t n)
{
    uint32_t steps = 0;
    while (n != 1 && steps < 500) {
        n = (n & 1) ? 3 * n + 1 : n >> 1;
        steps++;
    }
    return steps;
}

uint32_t sorted(int32_t *values)
{
    uint32_t i, j, moves = 0;
    for (i = 1; i < 8; i++)
        for (j = i; j > 0 && values[j - 1] > values[j]; j--) {
            const int32_t other = values[j];
            values[j] = values[j - 1];
            values[j - 1] = other;
            moves++;
        }
    return moves;
}
