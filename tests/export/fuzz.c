/* Rows of anything: what is refused leaves the state as it was, what is not leaves numbers; save and restore are exact. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include RN_REPLAY

static uint32_t seed = 12345u;

static uint32_t any(void)
{
    seed = seed * 1664525u + 1013904223u;
    return seed >> 8;
}

#ifdef RN_INTEGER
static int16_t wild(int16_t usual)
{
    static const int16_t ends[4] = {32767, -32768, 0, -1};
    const uint32_t kind = any() % 8u;
    if (kind < 4u) return usual;
    return (kind < 6u) ? ends[any() % 4u] : (int16_t)((int)(any() % 65536u) - 32768);
}
#else
static real wild(real usual)
{
    static const real ends[8] = {(real)NAN, (real)INFINITY, -(real)INFINITY, R(1e30), R(-1e30), R(1e-30), R(1e8), R(0.0)};
    const uint32_t kind = any() % 64u;
    return (kind < 60u) ? usual : ends[any() % 8u];
}
#endif

static int sane(const rn_replay_state *s)
{
    real out[RN_OUTPUTS];
    replay_output(s, out);
    for (int i = 0; i < RN_OUTPUTS; i++) {
        if (!isfinite(out[i])) return 0;
    }
    return 1;
}

int main(void)
{
    rn_replay_state state;
    rn_replay_state before;
    int refused = 0;
    if (replay_reset(&state) != 0) return 1;
    for (int k = 0; k < 60000; k++) {
        rn_row_number row[RN_COLUMNS];
        const int from = (int)(any() % (uint32_t)RN_ROWS);
        for (int i = 0; i < RN_COLUMNS; i++) row[i] = wild(replay_row[from][i]);
        before = state;
        if (replay_step(&state, row, replay_present[from]) != 0) {
            refused++;
            if (RN_WHOLE && (memcmp(&before, &state, sizeof state) != 0)) return 2;
        }
        if (!sane(&state)) return 3;
        if ((k % 1000) == 999) {
            SAVED(state, before)
        }
    }
    printf("refused %d of 60000\n", refused);
    return 0;
}
