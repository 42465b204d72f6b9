/* The alignment seen through doubles: one interface for the double and the float build. */
#ifndef RN_ALIGN_HOST_H
#define RN_ALIGN_HOST_H

#include <stddef.h>

#define RN_ALIGN_HOST_SETUP 15   /* numbers of the setup, in the order of rn_align.h */
#define RN_ALIGN_HOST_READING 30 /* numbers of a reading */
#define RN_ALIGN_HOST_ANSWER 22  /* q(4) tilt(2) tilt_cov(3) heading heading_var concentration biases(6) wind(2) compass bias, var */
#define RN_ALIGN_HOST_WIND 12    /* markov sd and time, frequencies (5), their sds (5); a frequency of 0 is no line */
#define RN_ALIGN_HOST_STATES 41
#define RN_ALIGN_HOST_LINES 5
#define RN_ALIGN_HOST_SAMPLES 100

/* One filter with one wind over n readings. */
typedef struct {
    size_t n;
    const double *setup, *wind, *q0, *v0, *readings;
    double *answer;         /* (n, RN_ALIGN_HOST_ANSWER) */
    double *log_likelihood; /* (n) */
    double *state;          /* q(4) v(2) biases(6) rate(2) compass bias, where there is one, wind(27) */
    double *P;              /* (states, states), the first n x n of them */
} rn_align_one;

/* The search for lines in one window. */
typedef struct {
    size_t n;
    const double *r;       /* (n, 2) */
    const double *weight;  /* (n) */
    double period, noise_sd, markov_sd, markov_time, goal;
    const double *poly_sd; /* (5) */
    double *omega, *omega_sd; /* (RN_ALIGN_HOST_LINES) */
    double alone, evidence;
    int lines;
} rn_align_lines;

size_t rn_align_bytes_double(void);
size_t rn_align_bytes_float(void);
/* 0, or -1 if the period is none the record was made for. */
int rn_align_begin_double(void *state, const double *setup);
int rn_align_begin_float(void *state, const double *setup);

/* Readings [from, to) through a state; an answer after every `every`-th since the start, NaN while there is none. */
typedef struct {
    void *state;
    const double *readings;
    double *answer;
    size_t every;
} rn_align_batch;
void rn_align_run_double(const rn_align_batch *batch, size_t from, size_t to);
void rn_align_run_float(const rn_align_batch *batch, size_t from, size_t to);

void rn_align_one_double(const rn_align_one *one);
void rn_align_one_float(const rn_align_one *one);
int rn_align_lines_double(rn_align_lines *call); /* -1 if the window does not fit, or is shorter than 1 s or longer than 1000 s */
int rn_align_lines_float(rn_align_lines *call);

#endif
