/* Replays the test vectors on a host: compares with what Python reached and prints a hash of every number of every state.
 * The same hash on a target means bit-identical runs.  Exit code 1: a difference above its bound. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include RN_REPLAY

int main(void)
{
    rn_replay_state state;
    uint32_t hash = 2166136261u; /* FNV-1a over the bytes */
    double worst = 0.0;
    int refused = (replay_reset(&state) != 0) ? RN_ROWS : 0;
    for (int k = 0; k < RN_ROWS; k++) {
        real out[RN_OUTPUTS];
        unsigned char bytes[sizeof out];
        refused += (replay_step(&state, replay_row[k], replay_present[k]) != 0) ? 1 : 0;
        replay_output(&state, out);
        memcpy(bytes, out, sizeof out);
        for (size_t i = 0; i < sizeof out; i++) hash = (hash ^ bytes[i]) * 16777619u;
        for (int i = 0; i < RN_OUTPUTS; i++) {
            const double share = fabs((double)out[i] - (double)replay_expected[k][i]) / replay_bound[i];
            if (!(share <= worst)) worst = share;
        }
    }
    printf("rows %d refused %d worst %.6f hash %08lx\n", RN_ROWS, refused, worst, (unsigned long)hash);
    return (refused >= RN_ROWS) || !(worst <= 1.0);
}
