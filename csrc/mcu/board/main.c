/* On a target: replays the test vectors, then runs the work whose cost is stated between two marker instructions that the
 * counting plugin sees, on a painted stack.  Prints "refused N hash XXXXXXXX stack N state N". */
#include <stdint.h>
#include <string.h>

#define RN_COUNTED
#include RN_REPLAY

#define BEGIN __asm__ volatile("mov r10, r10" ::: "memory") /* 0x46D2 */
#define END __asm__ volatile("mov r11, r11" ::: "memory")   /* 0x46DB */
#ifndef RN_STATE_BYTES
#define RN_STATE_BYTES sizeof state
#endif
#define PAINT 0xA5C3A5C3u
#define PAINT_LIMIT 65536u

void put(const char *text);
int main(void);
extern uint32_t __bss_end;

static rn_replay_state state;
static rn_row_number row[RN_COLUMNS];

__attribute__((noinline)) static int counted(void)
{
    int refused;
    BEGIN;
    refused = replay_counted(&state, row);
    END;
    return refused;
}

#ifdef RN_PROBE
/* What a firmware links that starts the filter and does the counted work: for the size alone, not run. */
int main(void)
{
    (void)replay_step;
    (void)replay_output;
    return replay_reset(&state) | counted();
}
#else
static void put_number(const char *name, uint32_t v)
{
    char text[12];
    int i = 11;
    text[11] = '\0';
    do {
        text[--i] = (char)('0' + (char)(v % 10u));
        v /= 10u;
    } while (v != 0u);
    put(name);
    put(text + i);
}

static void put_hash(uint32_t v)
{
    char text[9];
    for (int i = 0; i < 8; i++) text[i] = "0123456789abcdef"[(v >> (28 - 4 * i)) & 15u];
    text[8] = '\0';
    put(" hash ");
    put(text);
}

static uint32_t *stack_pointer(void)
{
    uint32_t *p;
    __asm__ volatile("mov %0, sp" : "=r"(p));
    return p;
}

static uint32_t replayed(uint32_t *refused)
{
    uint32_t hash = 2166136261u;
    *refused = (uint32_t)replay_reset(&state);
    for (int k = 0; k < RN_ROWS; k++) {
        real out[RN_OUTPUTS];
        unsigned char bytes[sizeof out];
        *refused += (uint32_t)(replay_step(&state, replay_row[k], replay_present[k]) != 0);
        replay_output(&state, out);
        memcpy(bytes, out, sizeof out);
        for (unsigned i = 0; i < sizeof out; i++) hash = (hash ^ bytes[i]) * 16777619u;
    }
    return hash;
}

int main(void)
{
    uint32_t refused;
    const uint32_t hash = replayed(&refused);
    uint32_t *const top = stack_pointer();
    uint32_t *low = &__bss_end;

    (void)replay_reset(&state);
    if ((uintptr_t)top - (uintptr_t)low > PAINT_LIMIT) low = top - PAINT_LIMIT / 4u;
    for (uint32_t *p = low; p < top; p++) *p = PAINT;
    for (int k = 1; k < RN_ROWS; k++) {
        if (replay_present[k] != replay_present[0]) continue;
        memcpy(row, replay_row[k], sizeof row);
        if (RN_COUNT != 0) (void)replay_step(&state, row, replay_present[k]);
        refused += (uint32_t)(counted() != 0);
    }
    const uint32_t *deepest = low;
    while (deepest < top && *deepest == PAINT) deepest++;

    put_number("refused ", refused);
    put_hash(hash);
    put_number(" stack ", (uint32_t)((uintptr_t)top - (uintptr_t)deepest));
    put_number(" state ", (uint32_t)(RN_STATE_BYTES));
    put("\n");
    return 0;
}
#endif
