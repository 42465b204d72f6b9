/* Initial alignment at rest on a swaying, wind-disturbed base: one step per pre-integrated reading.
 * No allocation, no globals; every number belongs to the caller.  The same in NumPy: robustnav.alignment.
 *
 * The navigation axes of the filter are level but turned about down by an unknown angle (the wander frame); the two
 * horizontal components of the Earth's rotation in it are states, and heading is read from them. */
#ifndef RN_ALIGN_H
#define RN_ALIGN_H

#include "rn_real.h"

#define RN_ALIGN_EARTH_RATE R(7.292115e-5) /* rad/s, WGS-84 */

enum {
    /* Where the common states stand: attitude 3, velocity 2, gyro bias 3, accelerometer bias 3, horizontal Earth rate 2. */
    RN_ALIGN_TURN = 0,
    RN_ALIGN_VELOCITY = 3,
    RN_ALIGN_GYRO = 5,
    RN_ALIGN_ACCEL = 8,
    RN_ALIGN_RATE = 11,
    RN_ALIGN_CORE = 13,
    RN_ALIGN_COMPASS = 13,   /* constant error of the compass, where there is one; it is common too */
    RN_ALIGN_COMMON = 14,
    RN_ALIGN_LINES = 5,      /* lines a filter can hold; each has north cos, sin, east cos, sin, frequency */
    RN_ALIGN_STATES = RN_ALIGN_COMMON + 5 * RN_ALIGN_LINES + 2,
    RN_ALIGN_BANK = 40,      /* winds without lines */
    RN_ALIGN_LINED = 8,      /* filters with the lines found, each in another noise */
    RN_ALIGN_NEXT = 2,       /* winds that may come next */
    RN_ALIGN_FILTERS = RN_ALIGN_BANK + RN_ALIGN_LINED + RN_ALIGN_NEXT,
    RN_ALIGN_READING = 30,   /* rotation 4, velocity 3, d velocity / d accel bias 9, d velocity / d gyro bias 9, z 2, field 3 */
    RN_ALIGN_VELOCITY_AT = 25, /* z: reference velocity north and east, NaN where missing */
    RN_ALIGN_FIELD_AT = 27,    /* magnetic field in body axes, any unit; NaN where missing */
    RN_ALIGN_RECORD = 600,   /* readings kept: the longest window, 60 s at the shortest period */
    RN_ALIGN_SNAPSHOTS = 7,
    RN_ALIGN_SAMPLES = 100   /* rows of an averaged window */
};

/* What is known before the start: SI and radians. */
typedef struct {
    real period;                            /* s between readings */
    real latitude;                          /* rad */
    real gravity;                           /* m/s^2 */
    real gyro_density, gyro_bias_sd, gyro_bias_walk;    /* rad/s/sqrt(Hz), rad/s, rad/s/sqrt(s) */
    real accel_density, accel_bias_sd, accel_bias_walk; /* m/s^2/sqrt(Hz), m/s^2, m/s^2/sqrt(s) */
    real reference_sd;                      /* m/s, white noise of the reference velocity */
    real gust_sd, gust_share;               /* m/s and how often */
    real declination, compass_sd, compass_bias_sd; /* rad; a compass_bias_sd of 0 is no compass */
} RN(align_setup);

/* A wind: a first-order Markov part and lines of roughly known frequency. */
typedef struct {
    real markov_sd, markov_time;            /* m/s, s */
    int lines;
    real omega[RN_ALIGN_LINES], omega_sd[RN_ALIGN_LINES]; /* rad/s */
} RN(align_wind);

/* Level attitude and what goes with it, in the wander frame. */
typedef struct {
    real q[4];    /* body to wander frame */
    real v[2];    /* m/s: velocity of the base and mean wind */
    real gyro_bias[3], accel_bias[3];
    real rate[2]; /* rad/s, horizontal Earth rate */
    real compass_bias; /* rad */
    real north;        /* rad: bearings are laid across it; set by the first */
    real steepness;    /* tangent of the field's dip, a mean over some seconds */
    int has_north;
} RN(align_core);

typedef struct {
    RN(align_wind) wind;
    RN(align_core) core;
    int anchored;               /* core is left alone by readings, and all is linear about it */
    real off[RN_ALIGN_COMMON];  /* then: from core to what is estimated */
    real d[5 * RN_ALIGN_LINES + 2]; /* lines, then Markov */
    int common; /* states before the wind's: one more with a compass */
    int n;
    real P[RN_ALIGN_STATES * RN_ALIGN_STATES]; /* n x n, row after row */
    real log_likelihood; /* of the last reading */
    real misfit;         /* squared normalised innovation of the last reading times its weight; 2 expected */
} RN(align_filter);

/* Heading and tilt of one filter, given that the horizontal Earth rate has its known length. */
typedef struct {
    real q[4];             /* wander attitude the tilt refers to */
    real tilt[2];          /* mean turn left to apply about x, y of the wander frame, rad */
    real tilt_cov[3];      /* xx, xy, yy, rad^2 */
    real heading;          /* of the body's forward axis, rad */
    real heading_var;      /* rad^2 */
    real concentration;    /* length of the mean heading vector: 0 nothing known, 1 known exactly */
    real gyro_bias[3], accel_bias[3];
    real wind[2];          /* m/s */
    real compass_bias, compass_bias_var; /* rad, rad^2; NaN without a compass */
} RN(align_answer);

typedef struct {
    RN(align_core) core, estimate;
    int anchored;
    real off[RN_ALIGN_COMMON];
    real P[RN_ALIGN_COMMON * RN_ALIGN_COMMON];
} RN(align_snapshot);

/* Lines in a window: evidence of the best set. */
typedef struct {
    real evidence;
    int lines;
    real omega[RN_ALIGN_LINES], omega_sd[RN_ALIGN_LINES];
} RN(align_spectrum);

typedef struct {
    real A[5 + 2 * RN_ALIGN_LINES][RN_ALIGN_SAMPLES]; /* whitened columns */
    real G[5 + 2 * RN_ALIGN_LINES][5 + 2 * RN_ALIGN_LINES], b[5 + 2 * RN_ALIGN_LINES][2];
    real precision[5 + 2 * RN_ALIGN_LINES];
    real r[2][RN_ALIGN_SAMPLES], weight[RN_ALIGN_SAMPLES];
    real white[2][RN_ALIGN_SAMPLES]; /* r whitened */
    real gain[RN_ALIGN_SAMPLES], scale[RN_ALIGN_SAMPLES], decay;
    real poly_sd[5];
    real period, noise_sd;
    int n;
} RN(align_window);

typedef struct {
    RN(align_setup) setup;
    int count;                                  /* readings so far */
    int next;                                   /* count at which the wind is identified again */
    real record[RN_ALIGN_RECORD][RN_ALIGN_READING];
    real best[RN_ALIGN_RECORD];                 /* score of the filter that led */
    real history[RN_ALIGN_RECORD];              /* log likelihood of that filter */
    RN(align_filter) filter[RN_ALIGN_FILTERS], trial; /* the bank, those with lines, those that may come next */
    int on[RN_ALIGN_FILTERS];                   /* whether it runs */
    real score[RN_ALIGN_FILTERS];               /* log likelihood, forgetting */
    real fit[RN_ALIGN_FILTERS];                 /* smoothed misfit */
    int changed;                                /* count at which the wind was found to have changed */
    int lines_from, next_from;                  /* reading from which the lines were found; the next winds started */
    RN(align_core) origin;                      /* where filters start */
    int recentred;                              /* how often */
    RN(align_snapshot) snapshot[RN_ALIGN_SNAPSHOTS];
    RN(align_window) window;
} RN(align);

/* rn_align_filter.c */
void RN(align_filter_start)(RN(align_filter) * f, const RN(align_setup) * s, const RN(align_wind) * w, const RN(align_core) * at);
void RN(align_filter_graft)(RN(align_filter) * f, const RN(align_setup) * s, const RN(align_wind) * w, const RN(align_snapshot) * from);
void RN(align_filter_motion)(RN(align_filter) * f, const RN(align_setup) * s, const real *reading); /* state only */
void RN(align_filter_predict)(RN(align_filter) * f, const RN(align_setup) * s, const real *reading);
void RN(align_filter_update)(RN(align_filter) * f, const RN(align_setup) * s, const real *z);
void RN(align_filter_inject)(RN(align_filter) * f, const real *dx);
void RN(align_filter_level)(const RN(align_filter) * f, RN(align_core) * x);
void RN(align_filter_estimate)(const RN(align_filter) * f, RN(align_core) * x);
void RN(align_filter_anchor)(RN(align_filter) * f);

/* rn_align_compass.c */
int RN(align_bearing)(const real *q, const real *field, real *azimuth, real *steepness); /* 0: no bearing */
void RN(align_filter_bearing)(RN(align_filter) * f, const RN(align_setup) * s, const real *field);
void RN(align_forget_odd_fields)(real *readings, int count, const RN(align_setup) * s, const real *q0);

/* rn_align_heading.c */
void RN(align_filter_answer)(const RN(align_filter) * f, const RN(align_setup) * s, RN(align_answer) * out);
void RN(align_mix)(const RN(align_answer) * in, const real *weight, int count, RN(align_answer) * out);

/* rn_align_lines.c */
real RN(align_given)(RN(align_window) * w, real markov_sd, real markov_time, const RN(align_spectrum) * lines);
real RN(align_whiten)(RN(align_window) * w, real markov_sd, real markov_time);
void RN(align_search)(RN(align_window) * w, real markov_sd, real markov_time, real goal, RN(align_spectrum) * found);

/* rn_align_wind.c */
void RN(align_bank_wind)(int i, RN(align_wind) * wind);
void RN(align_wide_wind)(int i, RN(align_wind) * wind); /* of those that may come next */
int RN(align_identify)(RN(align_window) * w, RN(align_wind) * out); /* RN_ALIGN_LINED at most; 0: no lines */

/* rn_align_record.c */
const real *RN(align_reading)(const RN(align) * a, int k);
int RN(align_missing)(const real *reading);
real RN(align_median)(const RN(align) * a, int from, int to, int axis);
real RN(align_oddness)(const RN(align) * a, int k, int from, int to);
real RN(align_odd_limit)(const RN(align) * a, int from, int to);
void RN(align_fill_window)(RN(align) * a, const RN(align_core) * from, int start, int stop);

/* rn_align_level.c */
void RN(align_level)(const real *readings, int count, const real *gyro_bias, real *q0);

/* rn_align.c */
int RN(align_start)(RN(align) * a, const RN(align_setup) * s); /* -1 unless 2 to 10 readings, a whole number, make a second */
void RN(align_step)(RN(align) * a, const real *reading);
int RN(align_read)(const RN(align) * a, RN(align_answer) * out); /* 0 before the first two seconds are over */

#endif
