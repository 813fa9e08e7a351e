/* Three functions of BLAS that MUMPS calls where OpenBLAS is slow, on top of that OpenBLAS.

   gemmt: C := alpha op(A) op(B) + beta C in one triangle of C, by products of blocks of columns. MUMPS spends nearly
   all of a symmetric factorization in it. OpenBLAS computes it column by column, by products of a matrix with a
   vector, at a tenth of the speed of its product of matrices.

   gemm and trsm with one column: what a substitution with one right-hand side consists of, by the functions for a
   vector, which read the matrix once and copy nothing. */

#include <stddef.h>

#define COLUMNS 64
#define PLAIN(WAY) (*(WAY) == 'N' || *(WAY) == 'n')

#define HASTENED(NAME, NUMBER)                                                                                \
    typedef void (*NAME##_product)(const char *, const char *, const int *, const int *, const int *,         \
                                   const NUMBER *, const NUMBER *, const int *, const NUMBER *, const int *,  \
                                   const NUMBER *, NUMBER *, const int *);                                    \
    typedef void (*NAME##_of_vector)(const char *, const int *, const int *, const NUMBER *, const NUMBER *,  \
                                     const int *, const NUMBER *, const int *, const NUMBER *, NUMBER *,      \
                                     const int *);                                                            \
    typedef void (*NAME##_solution)(const char *, const char *, const char *, const char *, const int *,      \
                                    const int *, const NUMBER *, const NUMBER *, const int *, NUMBER *,       \
                                    const int *);                                                             \
    typedef void (*NAME##_solution_of_vector)(const char *, const char *, const char *, const int *,          \
                                              const NUMBER *, const int *, NUMBER *, const int *);            \
    static NAME##_product NAME##_gemm;                                                                        \
    static NAME##_of_vector NAME##_gemv;                                                                      \
    static NAME##_solution NAME##_trsm;                                                                       \
    static NAME##_solution_of_vector NAME##_trsv;                                                             \
    void set_##NAME(void *gemm, void *gemv, void *trsm, void *trsv) {                                         \
        NAME##_gemm = (NAME##_product)gemm;                                                                   \
        NAME##_gemv = (NAME##_of_vector)gemv;                                                                 \
        NAME##_trsm = (NAME##_solution)trsm;                                                                  \
        NAME##_trsv = (NAME##_solution_of_vector)trsv;                                                        \
    }                                                                                                         \
    void NAME##gemm_(const char *a_as, const char *b_as, const int *rows, const int *columns,                 \
                     const int *depth, const NUMBER *alpha, const NUMBER *a, const int *lda, const NUMBER *b, \
                     const int *ldb, const NUMBER *beta, NUMBER *c, const int *ldc) {                         \
        int one = 1, plain = PLAIN(a_as);                                                                     \
        if (*columns == 1 && *depth > 0)                                                                      \
            NAME##_gemv(a_as, plain ? rows : depth, plain ? depth : rows, alpha, a, lda, b,                   \
                        PLAIN(b_as) ? &one : ldb, beta, c, &one);                                             \
        else                                                                                                  \
            NAME##_gemm(a_as, b_as, rows, columns, depth, alpha, a, lda, b, ldb, beta, c, ldc);               \
    }                                                                                                         \
    void NAME##trsm_(const char *side, const char *triangle, const char *a_as, const char *diagonal,          \
                     const int *rows, const int *columns, const NUMBER *alpha, const NUMBER *a,               \
                     const int *lda, NUMBER *b, const int *ldb) {                                             \
        int one = 1;                                                                                          \
        if (*columns == 1 && *alpha == 1 && (*side == 'L' || *side == 'l'))                                   \
            NAME##_trsv(triangle, a_as, diagonal, rows, a, lda, b, &one);                                     \
        else                                                                                                  \
            NAME##_trsm(side, triangle, a_as, diagonal, rows, columns, alpha, a, lda, b, ldb);                \
    }                                                                                                         \
    void NAME##gemmt_(const char *triangle, const char *a_as, const char *b_as, const int *size,              \
                      const int *depth, const NUMBER *alpha, const NUMBER *a, const int *lda,                 \
                      const NUMBER *b, const int *ldb, const NUMBER *beta, NUMBER *c, const int *ldc) {       \
        int upper = *triangle == 'U' || *triangle == 'u';                                                     \
        ptrdiff_t row_of_a = PLAIN(a_as) ? 1 : *lda;                                                          \
        ptrdiff_t column_of_b = PLAIN(b_as) ? *ldb : 1;                                                       \
        for (int first = 0; first < *size; first += COLUMNS) {                                                \
            int columns = *size - first < COLUMNS ? *size - first : COLUMNS, end = first + columns;           \
            /* The square on the diagonal by columns, the rest as one product. */                             \
            for (int column = first; column < end; column++) {                                                \
                int row = upper ? first : column, rows = upper ? column + 1 - first : end - column, one = 1;  \
                NAME##gemm_(a_as, b_as, &rows, &one, depth, alpha, a + row * row_of_a, lda,                   \
                            b + column * column_of_b, ldb, beta, c + row + (ptrdiff_t)column * *ldc, ldc);    \
            }                                                                                                 \
            int row = upper ? 0 : end, rows = upper ? first : *size - end;                                    \
            if (rows > 0)                                                                                     \
                NAME##_gemm(a_as, b_as, &rows, &columns, depth, alpha, a + row * row_of_a, lda,               \
                            b + first * column_of_b, ldb, beta, c + row + (ptrdiff_t)first * *ldc, ldc);      \
        }                                                                                                     \
    }

HASTENED(d, double)
HASTENED(s, float)
