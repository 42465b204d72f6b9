/* Every function of every built-in model, and the host's time loop, on sound and on hostile numbers.
 *
 * Built with the address and undefined-behaviour sanitizers: every array lies in a block of its own, of exactly the
 * size the interface promises, so one number read or written too far ends the program. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "rn_host.h"

#define ROWS 8   /* RN_MAX_ROWS: room per sensor in `seen` */
#define STEPS 200
#define ROUNDS 12

static int failures;

static void check(int holds, const char *model, const char *what)
{
    if (holds) return;
    failures++;
    fprintf(stderr, "%s: %s\n", model, what);
}

/* ---- numbers --------------------------------------------------------------------------------------------------- */

static uint64_t state = 88172645463325252u;

static uint64_t bits(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state;
}

static double uniform(void) { return (double)(bits() >> 11) / 9007199254740992.0; }

static double sound(void) { return 2.0 * uniform() - 1.0; }

static double hostile(void)
{
    static const double nasty[] = {0.0,    -0.0,   1.0,    -1.0,    (double)NAN, (double)INFINITY, -(double)INFINITY,
                                   1e300,  -1e300, 1e-300, 5e-324,  1e38,        -3.5e38,          1e-45,
                                   1e19,   -1e19,  2147483648.0,    -2147483649.0};
    return bits() % 3 ? sound() * 10.0 : nasty[bits() % (sizeof nasty / sizeof nasty[0])];
}

static double *numbers(size_t n, double (*draw)(void))
{
    double *out = malloc(n ? n * sizeof(double) : 1);
    if (!out) abort();
    for (size_t i = 0; i < n; i++) out[i] = draw();
    return out;
}

static double zero(void) { return 0.0; }
static double small_positive(void) { return 1e-6 + 1e-4 * uniform(); }

static int finite_all(const double *v, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(v[i])) return 0;
    }
    return 1;
}

/* A state from which every sound reading makes sense: the models begin with a unit quaternion or with angles. */
static double *start(const rn_info *m)
{
    double *x = numbers((size_t)m->nx, zero);
    if (m->nx != m->ne) x[0] = 1.0;
    return x;
}

/* ---- one function at a time ------------------------------------------------------------------------------------ */

static void call_each(const rn_host *host, const void *model, const rn_info *m, double (*draw)(void), int must_be_finite)
{
    for (int sensor = -1; sensor <= m->nsensors; sensor++) {
        const int there = sensor >= 0 && sensor < m->nsensors;
        const int size = there ? m->size[sensor] : 0, width = there ? m->width[sensor] : 0, rows = there ? m->rows[sensor] : 0, n = m->ne, all = m->rows_total;
        const int in_sizes[RN_CALL_COUNT][4] = {{m->nx, m->nu, m->np, 0}, {m->nx, m->nu, m->nq, m->np}, {m->nx, n, 0, 0},
                                                {m->nx, n, 0, 0},         {m->nx, m->nx, 0, 0},         {m->nx, width, m->np, 0},
                                                {m->nx, width, m->np, 0}, {m->nx, width, m->np, 0},     {n * all, all, 0, 0}};
        const int out_sizes[RN_CALL_COUNT][2] = {{m->nx, 0}, {n * n, n * n}, {m->nx, 0},    {m->nx, 0}, {n, 0},
                                                 {size, 0},  {rows, 0},      {rows * n, 0}, {n, 0}};
        for (int what = 0; what < RN_CALL_COUNT; what++) {
            double *in[4], *out[2];
            for (int i = 0; i < 4; i++) in[i] = numbers((size_t)in_sizes[what][i], draw);
            for (int i = 0; i < 2; i++) out[i] = numbers((size_t)out_sizes[what][i], zero);
            if (must_be_finite && what != RN_CALL_GAIN) {
                free(in[0]);
                in[0] = start(m);
            }
            const double *const given[4] = {in[0], in[1], in[2], in[3]};
            const double dt = must_be_finite ? 0.01 : hostile();
            const int fault = host->call(model, what, sensor, given, dt, out);
            const int needs_sensor = what == RN_CALL_MEASURE || what == RN_CALL_RESIDUAL || what == RN_CALL_JACOBIAN;
            check(fault == (needs_sensor && !there), m->name, "a call accepts or refuses the wrong sensor");
            for (int i = 0; i < 2 && must_be_finite; i++)
                check(finite_all(out[i], (size_t)out_sizes[what][i]), m->name, "sound input gave a number that is not finite");
            for (int i = 0; i < 4; i++) free(in[i]);
            for (int i = 0; i < 2; i++) free(out[i]);
        }
    }
}

/* ---- filters --------------------------------------------------------------------------------------------------- */

typedef struct {
    rn_config config;
    double *x, *P, *p, *q, *variance, *limit, *times, *gains, *L;
} setup_t;

static setup_t set_up(const void *model, const rn_info *m, int kind, double (*draw)(void))
{
    const size_t n = (size_t)m->ne, sensors = (size_t)m->nsensors;
    const size_t per_set = (((size_t)1 << sensors) - 1) * n * (size_t)m->rows_total;
    setup_t s = {.x = start(m),
                 .P = numbers(n * (n + 1) / 2, zero),
                 .p = numbers((size_t)m->np, draw),
                 .q = numbers((size_t)m->nq, small_positive),
                 .variance = numbers(sensors, small_positive),
                 .limit = numbers(sensors, zero),
                 .times = numbers(2, zero),
                 .gains = numbers(2 * per_set, draw),
                 .L = numbers(n * n, zero)};
    for (size_t i = 0; i < n; i++) s.L[i * n + i] = 1.0;
    for (size_t i = 0, k = 0; i < n; k += n - i, i++) s.P[k] = 0.01;
    for (size_t j = 0; j < sensors; j++) s.limit[j] = bits() % 2 ? (double)INFINITY : 4.0;
    for (size_t k = 0; k < 2 * per_set; k++) s.gains[k] *= 1e-3;
    s.times[1] = 0.5;
    s.config = (rn_config){.model = model, .kind = kind, .x = s.x, .P = kind == RN_KIND_FIXED ? NULL : s.P,
                           .p = s.p, .q = s.q, .variance = s.variance, .limit = s.limit,
                           .longest = draw == sound && bits() % 2 ? 0.004 : (double)INFINITY, .alpha = 1.0, .beta = 2.0, .kappa = 0.0,
                           .sets = kind == RN_KIND_FIXED ? 2 : 0, .times = s.times, .gains = s.gains,
                           .bounded = kind == RN_KIND_HINF ? m->ne : 0, .gamma = bits() % 2 ? 5.0 : 0.05, .L = s.L};
    for (size_t j = 0; j < sensors; j++) s.config.rule[j] = (int)(bits() % 3);
    return s;
}

static void *make_filter(const rn_host *host, const setup_t *s)
{
    void *filter = malloc(host->bytes(&s->config));
    if (!filter) abort();
    host->init(filter, &s->config);
    return filter;
}

static void tear_down(setup_t *s)
{
    double *const all[] = {s->x, s->P, s->p, s->q, s->variance, s->limit, s->times, s->gains, s->L};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) free(all[i]);
}

/* Steps one at a time: any input, any reading, any interval. */
static void stream_hostile(const rn_host *host, const void *model, const rn_info *m, int kind)
{
    setup_t s = set_up(model, m, kind, hostile);
    void *filter = make_filter(host, &s);
    const size_t packed = (size_t)m->ne * (size_t)(m->ne + 1) / 2;
    double *x = numbers((size_t)m->nx, zero), *P = numbers(packed, zero), time, elapsed;
    for (int k = 0; k < STEPS; k++) {
        double *u = numbers((size_t)m->nu, hostile), *z[RN_HOST_SENSORS] = {NULL}, *seen[RN_HOST_SENSORS] = {NULL};
        for (int j = 0; j < m->nsensors; j++) {
            if (bits() % 3) z[j] = numbers((size_t)m->width[j], hostile);
            if (bits() % 2) seen[j] = numbers(RN_SEEN, zero);
        }
        const double *given[RN_HOST_SENSORS];
        for (int j = 0; j < RN_HOST_SENSORS; j++) given[j] = z[j];
        host->predict(filter, u, bits() % 4 ? 0.01 : hostile());
        host->correct(filter, given, seen);
        if (k % 7 == 0) {
            host->store(filter, x, P, &time, &elapsed);
            host->load(filter, bits() % 2 ? s.x : x, bits() % 2 ? s.P : NULL, hostile(), hostile());
        }
        free(u);
        for (int j = 0; j < RN_HOST_SENSORS; j++) {
            free(z[j]);
            free(seen[j]);
        }
    }
    host->store(filter, NULL, NULL, NULL, NULL);
    free(x);
    free(P);
    free(filter);
    tear_down(&s);
}

/* ---- batches --------------------------------------------------------------------------------------------------- */

/* Times: rising; when not kind, with repeats, steps back, NaN and infinities. */
static double *times(size_t n, double step, int kind)
{
    double *t = numbers(n, zero), now = 0.0;
    for (size_t k = 0; k < n; k++) {
        t[k] = now;
        if (kind || bits() % 4) now += step;
        if (!kind && bits() % 16 == 0) t[k] = hostile();
    }
    return t;
}

static rn_batch new_batch(const rn_info *m, size_t n, double (*draw)(void), int kind, int filter)
{
    rn_batch b = {.n = n, .t = times(n, 0.01, kind), .u = numbers(n * (size_t)m->nu, draw)};
    const size_t ne = (size_t)m->ne;
    b.x = numbers(n * (size_t)m->nx, zero);
    if (filter != RN_KIND_FIXED) {
        b.sd = numbers(n * ne, zero);
        b.P = numbers(n * ne * (ne + 1) / 2, zero);
    }
    for (int j = 0; j < m->nsensors; j++) {
        if (!kind && bits() % 4 == 0) continue; /* a sensor that is not there */
        const size_t count = !kind && bits() % 4 == 0 ? 0 : n / 2 + bits() % 5;
        b.count[j] = count;
        b.ts[j] = times(count, 0.02, kind);
        b.z[j] = numbers(count * (size_t)m->width[j], draw);
        if (!kind && bits() % 3 == 0) continue; /* nobody wants the innovations */
        const int rows = filter >= RN_KIND_UKF ? m->size[j] : m->rows[j]; /* the unscented filter takes a reading whole */
        b.nu[j] = numbers(count * (size_t)rows, zero);
        b.s[j] = numbers(count * (size_t)rows, zero);
        b.nis[j] = numbers(count, zero);
        b.weight[j] = numbers(count, zero);
        b.margin[j] = numbers(count, zero);
    }
    return b;
}

static void free_batch(rn_batch *b)
{
    double *const outputs[] = {b->x, b->sd, b->P};
    for (size_t i = 0; i < 3; i++) free(outputs[i]);
    free((void *)(uintptr_t)b->t);
    free((void *)(uintptr_t)b->u);
    for (int j = 0; j < RN_HOST_SENSORS; j++) {
        free((void *)(uintptr_t)b->ts[j]);
        free((void *)(uintptr_t)b->z[j]);
        free(b->nu[j]);
        free(b->s[j]);
        free(b->nis[j]);
        free(b->weight[j]);
        free(b->margin[j]);
    }
}

static void check_batch(const rn_info *m, const rn_batch *b, int kind)
{
    for (int j = 0; j < m->nsensors; j++) {
        check(b->next[j] <= b->count[j], m->name, "the loop went past a stream's end");
        for (size_t k = 0; b->weight[j] && k < b->count[j]; k++)
            check(b->weight[j][k] >= 0.0 && b->weight[j][k] <= 1.0, m->name, "a weight is not in [0, 1]");
    }
    /* a model in increments: of any numbers its matrices and quaternion make states without bound */
    if (kind && strcmp(m->name, "alignment") != 0) check(finite_all(b->x, b->n * (size_t)m->nx), m->name, "a sound batch gave a state that is not finite");
}

static void run_hostile(const rn_host *host, const void *model, const rn_info *m, int kind)
{
    for (int round = 0; round < ROUNDS; round++) {
        setup_t s = set_up(model, m, kind, round % 2 ? hostile : sound);
        void *filter = make_filter(host, &s);
        rn_batch b = new_batch(m, bits() % 60, hostile, 0, kind);
        host->run(filter, &b, 0, b.n);
        check_batch(m, &b, 0);
        free_batch(&b);
        free(filter);
        tear_down(&s);
    }
}

/* A batch cut in two, with the filter put away and taken out again, is the same batch to the last bit. */
static void run_split(const rn_host *host, const void *model, const rn_info *m, int kind)
{
    const size_t n = STEPS, nx = (size_t)m->nx;
    setup_t s = set_up(model, m, kind, sound);
    rn_batch b = new_batch(m, n, sound, 1, kind);
    void *filter = make_filter(host, &s);
    host->run(filter, &b, 0, n);
    check_batch(m, &b, 1);
    double *whole = numbers(n * nx, zero);
    memcpy(whole, b.x, n * nx * sizeof(double));
    memset(b.next, 0, sizeof b.next);
    host->init(filter, &s.config);
    const size_t middle = n / 3;
    host->run(filter, &b, 0, middle);
    host->run(filter, &b, middle, n);
    check(memcmp(whole, b.x, n * nx * sizeof(double)) == 0, m->name, "a split batch differs from the whole one");
    free(whole);
    free(filter);
    free_batch(&b);
    tear_down(&s);
}

static int test_host(const rn_host *host, const char *name)
{
    int count = 0;
    for (const void *model; (model = host->built_in(count)) != NULL; count++) {
        rn_info m;
        memset(&m, 0, sizeof m);
        check(host->info(model, &m) == 0, name, "a built-in model is refused");
        for (int round = 0; round < ROUNDS; round++) {
            call_each(host, model, &m, sound, 1);
            call_each(host, model, &m, hostile, 0);
        }
        for (int kind = RN_KIND_EKF; kind <= RN_KIND_HINF; kind++) {
            stream_hostile(host, model, &m, kind);
            run_hostile(host, model, &m, kind);
            run_split(host, model, &m, kind);
        }
    }
    check(count > 0, name, "no built-in models");
    check(host->built_in(-1) == NULL && host->built_in(count) == NULL, name, "a model beyond the list");
    printf("%s: %d models\n", name, count);
    return count;
}

int main(void)
{
    alarm(600); /* a loop that never ends is a fault too */
    const int models = test_host(rn_host_double(), "double");
    check(test_host(rn_host_float(), "float") == models, "float", "another number of models than double");
    return failures ? 1 : 0;
}
