/* The kernel seen through doubles: one interface for the double and the float build, used by the Python extension. */
#ifndef RN_HOST_H
#define RN_HOST_H

#include <stddef.h>

#define RN_HOST_SENSORS 8

enum { RN_KIND_EKF = 0, RN_KIND_FIXED = 1, RN_KIND_UKF = 2, RN_KIND_HINF = 3 };
#define RN_SEEN (2 * 8 + 3) /* numbers a reading leaves: nu (8), s (8), nis, weight, margin of existence */
enum {
    RN_CALL_PROPAGATE,    /* in: x u p dt      out: x        */
    RN_CALL_TRANSITION,   /* in: x u q p dt    out: F Q      */
    RN_CALL_INJECT,       /* in: x e           out: x        */
    RN_CALL_INJECT_TURNED,/* in: x e           out: x        */
    RN_CALL_DIFFERENCE,   /* in: a b           out: e        */
    RN_CALL_MEASURE,      /* in: x z p         out: h        */
    RN_CALL_RESIDUAL,     /* in: x z p         out: r        */
    RN_CALL_JACOBIAN,     /* in: x z p         out: H        */
    RN_CALL_GAIN,         /* in: K r           out: e        */
    RN_CALL_COUNT
};

typedef struct {
    int nx, ne, nu, nq, np, nsensors, rows_total;
    int size[RN_HOST_SENSORS], width[RN_HOST_SENSORS], rows[RN_HOST_SENSORS];
    const char *name;
    const char *sensor[RN_HOST_SENSORS];
} rn_info;

typedef struct {
    const void *model;
    int kind;
    const double *x, *P, *p, *q, *variance; /* P packed; NULL for a constant gain */
    const double *limit;                    /* of each sensor's rule */
    int rule[RN_HOST_SENSORS];
    double longest;                         /* prediction made in one step [s] */
    int bounded;                            /* H-infinity: rows of L (bounded, ne), bound gamma */
    double gamma;
    const double *L;
    double alpha, beta, kappa;                     /* unscented */
    int sets;                                      /* gain sets: times (sets), gains (sets, 2^sensors - 1, ne, rows) */
    const double *times, *gains;
} rn_config;

/* One stretch of recording.  NULL outputs are not written; nu and s hold rows (unscented: size) numbers a reading. */
typedef struct {
    size_t n;
    const double *t, *u;
    size_t count[RN_HOST_SENSORS], next[RN_HOST_SENSORS];
    const double *ts[RN_HOST_SENSORS], *z[RN_HOST_SENSORS];
    double *x, *sd, *P;
    double *nu[RN_HOST_SENSORS], *s[RN_HOST_SENSORS], *nis[RN_HOST_SENSORS], *weight[RN_HOST_SENSORS], *margin[RN_HOST_SENSORS];
} rn_batch;

typedef struct {
    int abi, real_bytes;
    const void *(*built_in)(int index); /* NULL past the last */
    int (*info)(const void *model, rn_info *out);
    int (*call)(const void *model, int what, int sensor, const double *const in[], double dt, double *const out[]);
    size_t (*bytes)(const rn_config *config);
    void (*init)(void *filter, const rn_config *config);
    void (*load)(void *filter, const double *x, const double *P, double time, double elapsed); /* NULL: keep */
    void (*store)(const void *filter, double *x, double *P, double *time, double *elapsed);
    void (*predict)(void *filter, const double *u, double dt);
    /* z by sensor, NULL where there is no reading; seen: per sensor RN_SEEN numbers, or NULL */
    void (*correct)(void *filter, const double *const z[], double *const seen[]);
    /* rows [from, to) of the batch; the caller checks for interrupts between calls */
    void (*run)(void *filter, rn_batch *batch, size_t from, size_t to);
} rn_host;

const rn_host *rn_host_double(void);
const rn_host *rn_host_float(void);

#endif
