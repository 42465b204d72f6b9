/* What generated code says of a model: sizes and functions.  All arrays are caller-owned.
 *
 * x: state, nx numbers; e: error, ne numbers; u: input; p: parameters; q: noise intensities, one per noise block
 * [unit^2/Hz, two-sided]; P: covariance of the error, upper triangle by rows, ne(ne+1)/2 numbers.
 * Residuals are measured minus predicted; `rows` is how many scalar rows a sensor is fused as. */
#ifndef RN_MODEL_H
#define RN_MODEL_H

#include "rn_real.h"
#include "rn_update.h"

#define RN_ABI 7
#define RN_MAX_STATE 48
#define RN_MAX_INPUT 32
#define RN_MAX_PARAMETERS 32
#define RN_MAX_NOISES 16
#define RN_MAX_SENSORS 8
#define RN_MAX_ROWS 8
#define RN_MAX_READING 16
#define RN_PACKED(n) ((n) * ((n) + 1) / 2)

typedef struct {
    const char *name;
    int size;  /* numbers in a reading */
    int width; /* and with what travels behind them: the position of an anchor, a lever arm */
    int rows;  /* scalar rows it is fused as */
    int sees;  /* leading errors that a reading depends on: of those behind them it says nothing */
    void (*measure)(const real *x, const real *z, const real *p, real *h);       /* of z only what travels; h: size */
    void (*residual)(const real *x, const real *z, const real *p, real *r);      /* r: rows */
    void (*jacobian)(const real *x, const real *z, const real *p, real *H);      /* of z only what travels; H: rows x ne */
    void (*innovation)(const real *x, const real *z, const real *p, real *r);    /* z - h(x) in its own axes; r: size */
    /* Extended Kalman update by sequential scalar rows, all or nothing: x and P change unless the rule gives the reading no
     * weight, nis = sum nu^2 / s is not finite, or an innovation variance s is not positive definite.  Returns the weight. */
    real (*update)(real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p, real *nu, real *s, real *nis);
} RN(sensor);

typedef struct {
    int abi;
    int real_bytes;
    const char *name;
    int nx, ne, nu, nq, np, nsensors;
    int moving; /* leading errors that a step changes: it leaves the vectors behind them as they are */
    const RN(sensor) * sensors;
    void (*propagate)(real *x, const real *u, const real *p, real dt);
    void (*predict)(real *x, real *P, const real *u, const real *q, const real *p, real dt);
    /* F (ne x ne) and Q (ne x ne) of the step that starts at x */
    void (*transition)(const real *x, const real *u, const real *q, const real *p, real dt, real *F, real *Q);
    void (*noise)(const real *x, const real *u, const real *q, const real *p, real dt, real *Q); /* Q alone, packed */
    void (*inject)(real *x, const real *e);                      /* x <- x [+] e */
    void (*inject_turned)(real *x, const real *e);               /* the same, body vectors of e given in n */
    void (*difference)(const real *a, const real *b, real *e);   /* e = a [-] b */
    /* 2 ne points a [+] e, e by columns of ne rows: the step from a to b moves them, and e becomes what they are from b.
     * Only the moving rows change. */
    void (*carry)(const real *a, const real *b, const real *u, const real *p, real dt, real *e);
    void (*gain)(const real *K, const real *r, real *e);         /* e = K r over the gain's structural non-zeros */
    /* constant-gain correction with readings of all sensors, one after the other in z; r: their residuals */
    void (*correct)(real *x, const real *z, const real *K, const real *p, real *r);
} RN(model);

#endif
