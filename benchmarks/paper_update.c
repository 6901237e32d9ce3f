/* Eq. (10) transcribed literally from the paper, to count its cycles. 6 rules, 18 parameters.
 *
 *     q(k) = q(k-1) + K(k) (y(k+1) - u' q(k-1))
 *     K(k) = (P(k-1) u) / (lambda + u' P(k-1) u)
 *     P(k) = 1/lambda (I - K(k) u') P(k-1) = (P(k-1) - K(k) (u' P(k-1))) / lambda
 *
 * Every division of the equation is a division here, element by element. In float32 P loses its positive definiteness
 * after some hundred samples: this code serves for cycle counts only. */

enum { PARAMETERS = 18 };

typedef struct {
    float q[PARAMETERS];
    float p[PARAMETERS][PARAMETERS];
} paper_t;

void paper_update(paper_t *self, const float u[PARAMETERS], float y, float lambda);

void paper_update(paper_t *self, const float u[PARAMETERS], float y, float lambda)
{
    float pu[PARAMETERS];
    float up[PARAMETERS];
    float gain[PARAMETERS];
    float denominator = lambda;
    float error = y;

    for (int i = 0; i < PARAMETERS; ++i) {
        pu[i] = 0.0f;
        up[i] = 0.0f;
        for (int j = 0; j < PARAMETERS; ++j) {
            pu[i] += self->p[i][j] * u[j];
            up[i] += u[j] * self->p[j][i];
        }
    }
    for (int i = 0; i < PARAMETERS; ++i) {
        denominator += u[i] * pu[i];
        error -= u[i] * self->q[i];
    }
    for (int i = 0; i < PARAMETERS; ++i) {
        gain[i] = pu[i] / denominator;
        self->q[i] += gain[i] * error;
    }
    for (int i = 0; i < PARAMETERS; ++i) {
        for (int j = 0; j < PARAMETERS; ++j) {
            self->p[i][j] = (self->p[i][j] - gain[i] * up[j]) / lambda;
        }
    }
}
