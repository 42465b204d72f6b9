/* Many epochs, or one window, through the snapshot solver.  Included by snapshot_double.c and snapshot_float.c. */
#include "rn_snapshot_host.h"

#include <string.h>

#include "rn_snapshot.h"
#include "rn_snapshot_window.h"

/* The anchors in use and where they came from. */
typedef struct {
    double origin[3]; /* subtracted in double: a float far from the origin loses the residuals */
    unsigned char used[RN_FIX_ANCHORS];
    int from[RN_FIX_ANCHORS];
    RN(fix_problem) problem;
} layout_t;

static void set_up(const rn_fix_batch *b, const unsigned char *used, layout_t *out)
{
    RN(fix_problem) *q = &out->problem;
    memcpy(out->used, used, sizeof out->used);
    q->k = 0;
    for (int i = 0; i < b->k; i++) {
        if (!used[i]) continue;
        out->from[q->k] = i;
        for (int l = 0; l < 3; l++) {
            q->a[l][q->k] = l < b->d ? (real)(b->anchors[i * b->d + l] - out->origin[l]) : R(0.0);
        }
        q->w[q->k++] = (real)(1.0 / (b->sd[i] * b->sd[i]));
    }
    RN(fix_arrange)(q);
}

static void keep_candidate(double *out, const RN(fix_candidate) * from, const double *origin)
{
    for (int l = 0; l < 3; l++) out[l] = (double)from->p[l] + origin[l];
    for (int l = 0; l < 6; l++) out[3 + l] = (double)from->P[l];
}

static void keep(const rn_fix_batch *b, size_t epoch, const layout_t *layout, const RN(fix_result) * f)
{
    double *row = b->row + epoch * RN_FIX_ROW;
    const int whole[9] = {f->verdict, f->judged, f->cause, f->dof, f->steps, f->isolated, f->others, f->rivals, f->suspects};
    const real rest[8] = {f->gdop, f->hdop, f->vdop, f->weak[0], f->weak[1], f->weak[2], f->weak_sd, f->unseen_shift};
    for (int i = 0; i < 9; i++) row[i] = (double)whole[i];
    row[9] = (double)f->cost;
    keep_candidate(row + 10, &f->best, layout->origin);
    for (int i = 0; i < 8; i++) row[19 + i] = (double)rest[i];
    for (int l = 0; l < 3; l++) {
        row[27 + l] = (double)f->plane_point[l] + layout->origin[l];
        row[30 + l] = (double)f->plane_normal[l];
    }
    row[33] = (double)f->plane_distance;
    if (b->weights) {
        double *weights = b->weights + epoch * (size_t)b->k;
        for (int i = 0; i < b->k; i++) weights[i] = 0.0;
        for (int i = 0; i < layout->problem.k; i++) weights[layout->from[i]] = (double)f->weights[i];
    }
    for (int i = 0; b->others && i < f->others + f->rivals; i++) {
        double *other = b->others + (epoch * RN_FIX_HOST_OTHERS + (size_t)i) * RN_FIX_OTHER_ROW;
        keep_candidate(other, &f->other[i], layout->origin);
        other[9] = (double)f->other[i].cost;
    }
    for (int i = 0; b->suspects && i < f->suspects; i++) {
        double *suspect = b->suspects + (epoch * RN_FIX_HOST_ANCHORS + (size_t)i) * RN_FIX_SUSPECT_ROW;
        suspect[0] = (double)layout->from[f->suspect[i].anchor];
        suspect[1] = (double)f->suspect[i].error;
        suspect[2] = (double)f->suspect[i].sds;
    }
}

void RN_FIX_RUN(const rn_fix_batch *b, size_t from, size_t to)
{
    layout_t layout;
    RN(fix_options) options = {.max_gdop = (real)b->max_gdop, .repair = b->repair, .max_faults = b->max_faults, .judge = b->judge};
    RN(fix_problem) *q = &layout.problem;
    memset(&layout, 0, sizeof layout);
    for (int i = 0; i < RN_FIX_QUANTILES; i++) options.quantile[i] = (real)b->quantile[i];
    for (int i = 0; i < b->k; i++) {
        for (int l = 0; l < b->d; l++) layout.origin[l] += b->anchors[i * b->d + l] / b->k;
    }
    q->d = b->d;
    q->differences = b->differences;
    if (b->z_sd > 0.0) {
        q->z = (real)(b->z - layout.origin[2]);
        q->z_info = (real)(1.0 / (b->z_sd * b->z_sd));
    }
    for (size_t epoch = from; epoch < to; epoch++) {
        const double *z = b->readings + epoch * (size_t)(b->k - b->differences);
        unsigned char used[RN_FIX_ANCHORS] = {0};
        RN(fix_result) result;
        for (int i = 0; i < b->k; i++) used[i] = b->differences && i == 0 ? 1 : z[i - b->differences] == z[i - b->differences];
        if (epoch == from || memcmp(used, layout.used, sizeof used) != 0) set_up(b, used, &layout);
        for (int i = 0; i < q->k; i++) {
            const int anchor = layout.from[i] - b->differences;
            q->r[i] = anchor < 0 ? R(0.0) : (real)z[anchor];
        }
        RN(fix_solve)(q, &options, &result);
        keep(b, epoch, &layout, &result);
    }
}

int RN_WINDOW_RUN(rn_window_call *c)
{
    RN(window) w;
    RN(fix_candidate) found[RN_WINDOW_MINIMA];
    real guess[RN_WINDOW_GUESSES][3], track[RN_WINDOW_READINGS][3];
    double origin[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < 3 * c->m; i++) origin[i % 3] += c->first[i] / c->m;
    w.m = c->m;
    w.down_known = c->down_known;
    w.down = (real)(c->down - origin[2]);
    w.down_sd = (real)c->down_sd;
    for (int i = 0; i < c->m; i++) {
        w.value[i] = (real)c->value[i];
        w.sd[i] = (real)c->sd[i];
        w.pair[i] = c->pair[i];
        for (int l = 0; l < 3; l++) {
            w.first[i][l] = (real)(c->first[3 * i + l] - origin[l]);
            w.second[i][l] = (real)(c->second[3 * i + l] - origin[l]);
            if (c->track) track[i][l] = (real)(c->track[3 * i + l] - origin[l]);
        }
    }
    for (int i = 0; i < 3 * c->guesses; i++) guess[i / 3][i % 3] = (real)(c->guess[i] - origin[i % 3]);
    if (c->track) c->track_cost = (double)RN(window_cost)(&w, (const real(*)[3])track);
    const int count = RN(window_minima)(&w, (const real(*)[3])guess, c->guesses, found);
    for (int i = 0; i < count; i++) {
        double *row = c->minima + i * RN_FIX_OTHER_ROW;
        keep_candidate(row, &found[i], origin);
        row[9] = (double)found[i].cost;
    }
    return count;
}
