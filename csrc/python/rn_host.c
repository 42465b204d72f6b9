/* The host's filter object and its time loop over mixed-rate streams.  Included by host_double.c and host_float.c. */
#include "rn_host.h"

#include <string.h>

#include "rn_filter.h"
#include "rn_models.h"

typedef struct {
    const RN(model) * model;
    int kind, rows_total;
    int row_start[RN_HOST_SENSORS];
    double time;    /* of the state [s]; NaN before the first input */
    double elapsed; /* since the filter's start [s]: picks the gain set */
    double longest; /* prediction made in one step [s] */
    int bounded;    /* rows of L */
    real gamma_squared;
    int sets, set;
    RN(unscented) unscented;
    real x[RN_MAX_STATE + 1], P[RN_PACKED(RN_MAX_STATE)];
    real p[RN_MAX_PARAMETERS], q[RN_MAX_NOISES], variance[RN_HOST_SENSORS];
    RN(rule) rule[RN_HOST_SENSORS];
    real *gains, *L, *scratch; /* behind this struct, in the same block */
    double *times;
} filter_t;

/* A loop of a few turns: unrolling or vectorising it costs more than it saves. */
static int all_finite(const double *v, int n)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += v[i] * 0.0;
    return sum == 0.0;
}

/* Numbers in the kernel's type: as they are in double, copied to `room` in float. */
static const real *as_real(real *room, const double *v, int n)
{
#ifdef RN_FLOAT
    to_real(room, v, n);
    return room;
#else
    RN_UNUSED(room);
    RN_UNUSED(n);
    return v;
#endif
}

static const void *built_in(int index)
{
    const int count = (int)(sizeof rn_built_in / sizeof rn_built_in[0]) - 1;
    return index >= 0 && index < count ? rn_built_in[index] : NULL;
}

/* Returns what is wrong with a table that comes from outside: 0 none, 1 ABI, 2 number type, 3 sizes. */
static int info(const void *opaque, rn_info *out)
{
    const RN(model) *m = opaque;
    if (m->abi != RN_ABI) return 1;
    if (m->real_bytes != (int)sizeof(real)) return 2;
    if (m->nx > RN_MAX_STATE || m->ne > m->nx || m->moving > m->ne || m->nu > RN_MAX_INPUT || m->np > RN_MAX_PARAMETERS ||
        m->nq > RN_MAX_NOISES || m->nsensors > RN_HOST_SENSORS)
        return 3;
    *out = (rn_info){.nx = m->nx, .ne = m->ne, .nu = m->nu, .nq = m->nq, .np = m->np, .nsensors = m->nsensors, .name = m->name};
    for (int j = 0; j < m->nsensors; j++) {
        const RN(sensor) *one = &m->sensors[j];
        if (one->size > RN_MAX_ROWS || one->rows > RN_MAX_ROWS || one->sees > m->ne || one->width > RN_MAX_READING) return 3;
        out->size[j] = m->sensors[j].size;
        out->width[j] = m->sensors[j].width;
        out->rows[j] = m->sensors[j].rows;
        out->sensor[j] = m->sensors[j].name;
        out->rows_total += out->rows[j];
    }
    return 0;
}

static size_t gain_numbers(const rn_config *c)
{
    const RN(model) *m = c->model;
    size_t rows = 0;
    for (int j = 0; j < m->nsensors; j++) rows += (size_t)m->sensors[j].rows;
    return (size_t)c->sets * (((size_t)1 << m->nsensors) - 1) * (size_t)m->ne * rows;
}

static size_t bytes(const rn_config *c)
{
    const RN(model) *m = c->model;
    const size_t scratch = c->kind >= RN_KIND_UKF ? (size_t)RN(ukf_scratch)(m) : 0;
    const size_t bound = (size_t)c->bounded * (size_t)m->ne;
    return sizeof(filter_t) + (size_t)c->sets * sizeof(double) + (gain_numbers(c) + bound + scratch) * sizeof(real);
}

static void init(void *memory, const rn_config *c)
{
    filter_t *f = memory;
    const RN(model) *m = c->model;
    memset(f, 0, bytes(c));
    f->model = m;
    f->kind = c->kind;
    f->sets = c->sets;
    for (int j = 0; j < m->nsensors; j++) {
        f->row_start[j] = f->rows_total;
        f->rows_total += m->sensors[j].rows;
    }
    f->times = (double *)(void *)(f + 1);
    f->gains = (real *)(void *)(f->times + c->sets);
    f->L = f->gains + gain_numbers(c);
    f->scratch = f->L + (size_t)c->bounded * (size_t)m->ne;
    f->bounded = c->bounded;
    f->gamma_squared = (real)(c->gamma * c->gamma);
    to_real(f->L, c->L, c->bounded * m->ne);
    for (int i = 0; i < c->sets; i++) f->times[i] = c->times[i];
    for (size_t i = 0; i < gain_numbers(c); i++) f->gains[i] = (real)c->gains[i];
    to_real(f->x, c->x, m->nx);
    if (c->P) to_real(f->P, c->P, RN_PACKED(m->ne));
    to_real(f->p, c->p, m->np);
    to_real(f->q, c->q, m->nq);
    to_real(f->variance, c->variance, m->nsensors);
    for (int j = 0; j < m->nsensors; j++) f->rule[j] = (RN(rule)){c->rule[j], (real)c->limit[j]};
    const double n = (double)m->ne, spread = c->alpha * c->alpha * (n + c->kappa);
    f->unscented.spread = (real)spread;
    f->unscented.mean_centre = (real)((spread - n) / spread);
    f->unscented.cov_centre = (real)((spread - n) / spread + 1.0 - c->alpha * c->alpha + c->beta);
    f->longest = c->longest;
    f->time = NAN;
}

static void load(void *memory, const double *x, const double *P, double time, double elapsed)
{
    filter_t *f = memory;
    if (x) to_real(f->x, x, f->model->nx);
    if (P) to_real(f->P, P, RN_PACKED(f->model->ne));
    f->time = time;
    f->elapsed = elapsed;
    f->set = 0;
}

static void store(const void *memory, double *x, double *P, double *time, double *elapsed)
{
    const filter_t *f = memory;
    if (x) to_double(x, f->x, f->model->nx);
    if (P) to_double(P, f->P, RN_PACKED(f->model->ne));
    if (time) *time = f->time;
    if (elapsed) *elapsed = f->elapsed;
}

static void step(filter_t *f, const real *input, double dt)
{
    switch (f->kind) {
    case RN_KIND_FIXED: f->model->propagate(f->x, input, f->p, (real)dt); break;
    case RN_KIND_UKF:
    case RN_KIND_HINF:
        if (RN(ukf_predict)(f->model, &f->unscented, f->x, f->P, input, f->q, f->p, (real)dt, f->scratch))
            f->P[0] = (real)NAN; /* a covariance that lost definiteness stays visible */
        break;
    default: f->model->predict(f->x, f->P, input, f->q, f->p, (real)dt); break;
    }
}

static void predict(void *memory, const double *u, double dt)
{
    enum { MOST_PARTS = 10000 };
    filter_t *f = memory;
    real room[RN_MAX_INPUT];
    const real *input = as_real(room, u, f->model->nu);
    f->elapsed += dt;
    f->time += dt;
    if (!(dt > f->longest)) {
        step(f, input, dt);
        return;
    }
    const double parts = fmin(ceil(dt / f->longest), MOST_PARTS);
    for (int i = 0; i < (int)parts; i++) step(f, input, dt / parts);
}

/* Rows a reading is fused as: the unscented filter takes it as it is. */
static int seen_rows(const filter_t *f, int j)
{
    return f->kind >= RN_KIND_UKF ? f->model->sensors[j].size : f->model->sensors[j].rows;
}

static void keep_seen(double *out, const RN(seen) * seen, int rows)
{
    if (!out) return;
    to_double(out, seen->nu, rows);
    to_double(out + RN_MAX_ROWS, seen->s, rows);
    out[2 * RN_MAX_ROWS] = (double)seen->nis;
    out[2 * RN_MAX_ROWS + 1] = (double)seen->weight;
    out[2 * RN_MAX_ROWS + 2] = (double)NAN;
}

static void correct_fixed(filter_t *f, const double *const z[], double *const seen[])
{
    const RN(model) *m = f->model;
    real all[RN_HOST_SENSORS * RN_MAX_READING], r[RN_HOST_SENSORS * RN_MAX_ROWS], *reading = all;
    const int whole = (1 << m->nsensors) - 1;
    int mask = 0;
    for (int j = 0; j < m->nsensors; j++) {
        if (z[j] == NULL || !all_finite(z[j], m->sensors[j].width)) continue;
        mask |= 1 << j;
        to_real(reading, z[j], m->sensors[j].width);
        reading += m->sensors[j].width;
    }
    if (!mask) return;
    while (f->set + 1 < f->sets && f->elapsed >= f->times[f->set + 1]) f->set++;
    const size_t one = (size_t)(m->ne * f->rows_total), subsets = ((size_t)1 << m->nsensors) - 1;
    const real *K = f->gains + ((size_t)f->set * subsets + (size_t)(mask - 1)) * one;
    if (mask == whole)
        m->correct(f->x, all, K, f->p, r);
    else
        RN(fixed_correct)(m, f->x, K, all, mask, f->p, r);
    for (int j = 0; j < m->nsensors; j++) {
        if (!seen[j] || !(mask >> j & 1)) continue;
        RN(seen) kept = {.nis = (real)NAN, .weight = R(1.0)};
        for (int a = 0; a < m->sensors[j].rows; a++) {
            kept.nu[a] = r[f->row_start[j] + a];
            kept.s[a] = (real)NAN;
        }
        keep_seen(seen[j], &kept, m->sensors[j].rows);
    }
}

static void correct(void *memory, const double *const z[], double *const seen[])
{
    filter_t *f = memory;
    const RN(model) *m = f->model;
    if (f->kind == RN_KIND_FIXED) {
        correct_fixed(f, z, seen);
        return;
    }
    int used = 0;
    for (int j = 0; j < m->nsensors; j++) {
        real room[RN_MAX_READING];
        RN(seen) one;
        if (z[j] == NULL || !all_finite(z[j], m->sensors[j].width)) continue;
        const real *reading = as_real(room, z[j], m->sensors[j].width);
        if (f->kind >= RN_KIND_UKF)
            RN(ukf_update)(m, &f->unscented, j, f->x, f->P, reading, f->variance[j], f->rule[j], f->p, &one, f->scratch);
        else
            one.weight = m->sensors[j].update(f->x, f->P, reading, f->variance[j], f->rule[j], f->p, one.nu, one.s, &one.nis);
        keep_seen(seen[j], &one, seen_rows(f, j));
        used |= one.weight > R(0.0);
    }
    if (f->kind != RN_KIND_HINF || !used) return;
    real margin;
    RN(hinf_enlarge)(f->P, f->L, f->bounded, m->ne, f->gamma_squared, &margin, f->scratch);
    for (int j = 0; j < m->nsensors; j++) {
        if (seen[j] && z[j]) seen[j][2 * RN_MAX_ROWS + 2] = (double)margin;
    }
}

/* Fuse every reading stamped `at`, and move past it. */
static void take(filter_t *f, rn_batch *b, double at)
{
    const RN(model) *m = f->model;
    const double *z[RN_HOST_SENSORS] = {NULL};
    double kept[RN_HOST_SENSORS][RN_SEEN], *seen[RN_HOST_SENSORS] = {NULL};
    size_t row[RN_HOST_SENSORS];
    for (;;) {
        int any = 0;
        for (int j = 0; j < m->nsensors; j++) {
            z[j] = NULL;
            if (b->next[j] >= b->count[j] || b->ts[j][b->next[j]] != at) continue;
            row[j] = b->next[j]++;
            z[j] = b->z[j] + row[j] * (size_t)m->sensors[j].width;
            seen[j] = b->nu[j] ? kept[j] : NULL;
            kept[j][2 * RN_MAX_ROWS + 1] = -1.0; /* stays so when the reading is missing */
            any = 1;
        }
        if (!any) return;
        correct(f, z, seen);
        for (int j = 0; j < m->nsensors; j++) {
            if (!z[j] || !b->nu[j] || kept[j][2 * RN_MAX_ROWS + 1] < 0.0) continue;
            const size_t rows = (size_t)seen_rows(f, j);
            memcpy(b->nu[j] + row[j] * rows, kept[j], rows * sizeof(double));
            memcpy(b->s[j] + row[j] * rows, kept[j] + RN_MAX_ROWS, rows * sizeof(double));
            b->nis[j][row[j]] = kept[j][2 * RN_MAX_ROWS];
            b->weight[j][row[j]] = kept[j][2 * RN_MAX_ROWS + 1];
            b->margin[j][row[j]] = kept[j][2 * RN_MAX_ROWS + 2];
        }
    }
}

static double earliest(const rn_batch *b, int sensors)
{
    double at = INFINITY;
    for (int j = 0; j < sensors; j++) {
        if (b->next[j] < b->count[j] && b->ts[j][b->next[j]] < at) at = b->ts[j][b->next[j]];
    }
    return at;
}

static void report(const filter_t *f, rn_batch *b, size_t k)
{
    const size_t nx = (size_t)f->model->nx, ne = (size_t)f->model->ne, packed = (size_t)RN_PACKED(f->model->ne);
    if (b->x) to_double(b->x + k * nx, f->x, (int)nx);
    if (b->P) to_double(b->P + k * packed, f->P, (int)packed);
    if (b->sd) {
        const real *diagonal = f->P;
        for (size_t i = 0; i < ne; i++) {
            b->sd[k * ne + i] = sqrt((double)*diagonal);
            diagonal += ne - i;
        }
    }
}

static void run(void *memory, rn_batch *b, size_t from, size_t to)
{
    filter_t *f = memory;
    const int nu = f->model->nu, sensors = f->model->nsensors;
    for (size_t k = from; k < to; k++) {
        const double t = b->t[k], *u = b->u + k * (size_t)nu;
        if (all_finite(u, nu)) { /* a missing input is an absent one: the next covers its time */
            if (!(f->time == f->time)) f->time = t;
            for (;;) {
                const double at = earliest(b, sensors);
                if (!(at < t)) break;
                if (at >= f->time) {
                    if (at > f->time) predict(f, u, at - f->time);
                    f->time = at;
                    take(f, b, at);
                } else { /* before the filter's start: not used */
                    for (int j = 0; j < sensors; j++) {
                        if (b->next[j] < b->count[j] && b->ts[j][b->next[j]] == at) b->next[j]++;
                    }
                }
            }
            if (t > f->time) predict(f, u, t - f->time);
            f->time = t;
            take(f, b, t);
        }
        report(f, b, k);
    }
}

const rn_host *RN_HOST_NAME(void)
{
    static const rn_host host = {RN_ABI, (int)sizeof(real), built_in, info, call, bytes, init,
                                 load,   store,             predict,  correct, run};
    return &host;
}
