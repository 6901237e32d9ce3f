/* Orthogonal triangularisation of rows under a triangular factor, float64:
 *
 *   [R; A] = Q [R'; 0],   R, R' (size, size) upper triangular, A (rows, size)
 *
 * Column j of R has one element that is not zero at or below row j, so its Householder vector is [R_jj; A_j] and the rows
 * of R below j stay untouched. Loops run along rows, which lie together in memory. */

#include <float.h>
#include <math.h>
#include <stddef.h>

/* Rows per block, so that a block stays in the processor's cache. */
#define BLOCK 256

static void one_block(size_t rows, size_t size, double *restrict R, double *restrict A, double *restrict work)
{
    for (size_t j = 0; j < size; ++j) {
        double *restrict Rj = R + j * size;
        double square = 0.0;
        for (size_t i = 0; i < rows; ++i) {
            square += A[i * size + j] * A[i * size + j];
        }
        if (square < DBL_MIN) {
            continue; /* 2 / |v|^2 would be infinite; elements below 1e-154 change no other */
        }
        const double length = sqrt(Rj[j] * Rj[j] + square);
        /* The sign that adds, so that head = R_jj + sign length cannot cancel. */
        const double head = (Rj[j] >= 0.0) ? Rj[j] + length : Rj[j] - length;
        const double scale = 1.0 / (length * fabs(head)); /* 2 / |v|^2 */
        for (size_t c = j; c < size; ++c) {
            work[c] = head * Rj[c];
        }
        for (size_t i = 0; i < rows; ++i) {
            const double *row = A + i * size;
            for (size_t c = j; c < size; ++c) {
                work[c] += row[j] * row[c];
            }
        }
        for (size_t c = j; c < size; ++c) {
            work[c] *= scale;
            Rj[c] -= head * work[c];
        }
        for (size_t i = 0; i < rows; ++i) {
            double *row = A + i * size;
            const double v = row[j];
            for (size_t c = j + 1; c < size; ++c) {
                row[c] -= v * work[c];
            }
        }
    }
}

/* R is updated; A is overwritten; work (size). */
void hysgen_triangular(size_t rows, size_t size, double *R, double *A, double *work)
{
    for (size_t start = 0; start < rows; start += BLOCK) {
        const size_t count = (rows - start < BLOCK) ? rows - start : BLOCK;
        one_block(count, size, R, A + start * size, work);
    }
}
