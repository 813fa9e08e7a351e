/* C := alpha op(A) op(B) + beta C in one triangle of C, by products of blocks of columns.

   MUMPS spends nearly all of a symmetric factorization in it. OpenBLAS computes it column by column, by products of
   a matrix with a vector, at a tenth of the speed of its product of matrices. */

#include <stddef.h>

#define COLUMNS 64

#define TRIANGLE(NAME, NUMBER)                                                                                \
    typedef void (*NAME##_product)(const char *, const char *, const int *, const int *, const int *,         \
                                   const NUMBER *, const NUMBER *, const int *, const NUMBER *, const int *,  \
                                   const NUMBER *, NUMBER *, const int *);                                    \
    static NAME##_product NAME##_gemm;                                                                        \
    void set_##NAME##_gemm(void *given) { NAME##_gemm = (NAME##_product)given; }                              \
    void NAME##gemmt_(const char *triangle, const char *a_as, const char *b_as, const int *size,              \
                      const int *depth, const NUMBER *alpha, const NUMBER *a, const int *lda,                 \
                      const NUMBER *b, const int *ldb, const NUMBER *beta, NUMBER *c, const int *ldc) {       \
        int upper = *triangle == 'U' || *triangle == 'u';                                                     \
        ptrdiff_t row_of_a = *a_as == 'N' || *a_as == 'n' ? 1 : *lda;                                         \
        ptrdiff_t column_of_b = *b_as == 'N' || *b_as == 'n' ? *ldb : 1;                                      \
        for (int first = 0; first < *size; first += COLUMNS) {                                                \
            int columns = *size - first < COLUMNS ? *size - first : COLUMNS, end = first + columns;           \
            /* The square on the diagonal by columns, the rest as one product. */                             \
            for (int column = first; column < end; column++) {                                                \
                int row = upper ? first : column, rows = upper ? column + 1 - first : end - column, one = 1;  \
                NAME##_gemm(a_as, b_as, &rows, &one, depth, alpha, a + row * row_of_a, lda,                   \
                            b + column * column_of_b, ldb, beta, c + row + (ptrdiff_t)column * *ldc, ldc);    \
            }                                                                                                 \
            int row = upper ? 0 : end, rows = upper ? first : *size - end;                                    \
            if (rows > 0)                                                                                     \
                NAME##_gemm(a_as, b_as, &rows, &columns, depth, alpha, a + row * row_of_a, lda,               \
                            b + first * column_of_b, ldb, beta, c + row + (ptrdiff_t)first * *ldc, ldc);      \
        }                                                                                                     \
    }

TRIANGLE(d, double)
TRIANGLE(s, float)
