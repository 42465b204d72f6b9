/* QEMU TCG plugin: counts guest instructions, loads, stores and divide/square-root instructions between two marker
 * opcodes, per window.  Debian ships no qemu-plugin.h, so the few entry points used are declared here by hand.
 *   gcc -O2 -shared -fPIC -DPLUGIN_API=1 -o count.so count.c    (QEMU 7.2: 1;  QEMU 10.0: 3)
 *   qemu-system-arm ... -plugin count.so,out=FILE */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#ifndef PLUGIN_API
#define PLUGIN_API 1
#endif
#define MARK_BEGIN 0x46D2u /* mov r10, r10 */
#define MARK_END 0x46DBu   /* mov r11, r11 */
#define EXPORT __attribute__((visibility("default")))

typedef uint64_t plugin_id;
struct block;
struct insn;
enum { NO_REGS = 0, MEM_READ_WRITE = 3 };

size_t qemu_plugin_tb_n_insns(const struct block *);
struct insn *qemu_plugin_tb_get_insn(const struct block *, size_t);
size_t qemu_plugin_insn_size(const struct insn *);
#if PLUGIN_API >= 3
size_t qemu_plugin_insn_data(const struct insn *, void *to, size_t length);
#else
const void *qemu_plugin_insn_data(const struct insn *);
#endif
void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id, void (*)(plugin_id, struct block *));
void qemu_plugin_register_vcpu_insn_exec_cb(struct insn *, void (*)(unsigned, void *), int flags, void *);
void qemu_plugin_register_vcpu_mem_cb(struct insn *, void (*)(unsigned, uint32_t, uint64_t, void *), int flags, int rw,
                                      void *);
void qemu_plugin_register_atexit_cb(plugin_id, void (*)(plugin_id, void *), void *);
bool qemu_plugin_mem_is_store(uint32_t info);

EXPORT int qemu_plugin_version = PLUGIN_API;

struct counts { uint64_t insns, loads, stores, divs; };
static struct counts now, sum;
static uint64_t executed, windows, least = UINT64_MAX, most;
static bool active;
static FILE *out;

static void on_insn(unsigned cpu, void *is_div)
{
    (void)cpu;
    executed++;
    if (!active) return;
    now.insns++;
    now.divs += is_div != NULL;
}

static void on_memory(unsigned cpu, uint32_t info, uint64_t address, void *data)
{
    (void)cpu, (void)address, (void)data;
    if (!active) return;
    if (qemu_plugin_mem_is_store(info)) now.stores++;
    else now.loads++;
}

static void on_begin(unsigned cpu, void *data)
{
    (void)cpu, (void)data;
    executed++;
    now = (struct counts){ 0 };
    active = true;
}

static void on_end(unsigned cpu, void *data)
{
    (void)cpu, (void)data;
    executed++;
    if (!active) return;
    active = false;
    windows++;
    sum.insns += now.insns, sum.loads += now.loads, sum.stores += now.stores, sum.divs += now.divs;
    if (now.insns < least) least = now.insns;
    if (now.insns > most) most = now.insns;
}

static bool divides(size_t size, uint16_t first, uint16_t second)
{
    if (size != 4) return false;
    const bool vdiv = (first & 0xFFB0u) == 0xEE80u && (second & 0x0E50u) == 0x0A00u;
    const bool vsqrt = (first & 0xFFBFu) == 0xEEB1u && (second & 0x0ED0u) == 0x0AC0u;
    const bool integer = (first & 0xFFD0u) == 0xFB90u && (second & 0xF0u) == 0xF0u;
    return vdiv || vsqrt || integer;
}

static void on_translate(plugin_id id, struct block *block)
{
    (void)id;
    for (size_t i = 0, n = qemu_plugin_tb_n_insns(block); i < n; i++) {
        struct insn *insn = qemu_plugin_tb_get_insn(block, i);
        const size_t size = qemu_plugin_insn_size(insn);
        uint8_t b[4] = { 0 };
#if PLUGIN_API >= 3
        qemu_plugin_insn_data(insn, b, sizeof b);
#else
        memcpy(b, qemu_plugin_insn_data(insn), size < 4 ? size : 4);
#endif
        const uint16_t first = (uint16_t)(b[0] | b[1] << 8), second = (uint16_t)(b[2] | b[3] << 8);
        if (size == 2 && first == MARK_BEGIN) {
            qemu_plugin_register_vcpu_insn_exec_cb(insn, on_begin, NO_REGS, NULL);
        } else if (size == 2 && first == MARK_END) {
            qemu_plugin_register_vcpu_insn_exec_cb(insn, on_end, NO_REGS, NULL);
        } else {
            void *is_div = divides(size, first, second) ? insn : NULL;
            qemu_plugin_register_vcpu_insn_exec_cb(insn, on_insn, NO_REGS, is_div);
            qemu_plugin_register_vcpu_mem_cb(insn, on_memory, NO_REGS, MEM_READ_WRITE, NULL);
        }
    }
}

static void on_exit(plugin_id id, void *data)
{
    (void)id, (void)data;
    const double n = windows ? (double)windows : 1.0;
    fprintf(out, "executed %llu windows %llu mean %.2f min %llu max %llu loads %.2f stores %.2f divs %.2f\n",
            (unsigned long long)executed, (unsigned long long)windows, (double)sum.insns / n,
            (unsigned long long)(windows ? least : 0), (unsigned long long)most, (double)sum.loads / n,
            (double)sum.stores / n, (double)sum.divs / n);
    fclose(out);
}

EXPORT int qemu_plugin_install(plugin_id id, const void *info, int argc, char **argv)
{
    (void)info;
    for (int i = 0; i < argc; i++) {
        if (!strncmp(argv[i], "out=", 4)) out = fopen(argv[i] + 4, "w");
    }
    if (!out) return -1;
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_translate);
    qemu_plugin_register_atexit_cb(id, on_exit, NULL);
    return 0;
}
