/* One recursive least-squares update in Bierman's UD form, P = U D U', with loops of constant length. */
#include <stdint.h>

#define N 18
#define FORGETTING 0.999f
#define FORGETTING_INVERSE 1.001001f

typedef struct {
    float theta[N], d[N], u[N * (N - 1) / 2]; /* U's columns above the unit diagonal, one after the other */
} learner_t;

void learn(learner_t *self, const float *phi, float error);

typedef union {
    float value;
    uint32_t bits;
} image_t;

static float reciprocal(float x)
{
    image_t r, d;
    int i;
    d.value = x;
    r.bits = 0x7EF311C7u - d.bits;
    for (i = 0; i < 3; i++)
        r.value = r.value * (2.0f - x * r.value);
    return r.value;
}

void learn(learner_t *self, const float *phi, float error)
{
    float f[N], g[N], gain[N], alpha = FORGETTING, inverse = FORGETTING_INVERSE;
    float *column = self->u;
    int i, j;
    for (j = 0; j < N; j++) {
        f[j] = phi[j];
        for (i = 0; i < j; i++)
            f[j] = f[j] + column[i] * phi[i];
        g[j] = self->d[j] * f[j];
        column += j;
    }
    column = self->u;
    for (j = 0; j < N; j++) {
        const float next = alpha + f[j] * g[j], next_inverse = reciprocal(next), shift = -f[j] * inverse;
        self->d[j] = self->d[j] * (alpha * next_inverse) * FORGETTING_INVERSE;
        for (i = 0; i < j; i++) {
            const float old = column[i];
            column[i] = old + gain[i] * shift;
            gain[i] = gain[i] + g[j] * old;
        }
        gain[j] = g[j];
        alpha = next;
        inverse = next_inverse;
        column += j;
    }
    for (i = 0; i < N; i++)
        self->theta[i] = self->theta[i] + gain[i] * (error * inverse);
}
