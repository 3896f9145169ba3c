/* The chip as a whole: opening, closing, resets, running, memory.
 *
 * The shim is a small C face on libsimavr for shim.py: plain integers and buffers. No struct of simavr crosses that
 * border, so Python maps nothing of it. Nothing here prints or exits: a fault leaves a message in the handle and a
 * status that Python turns into an exception.
 *
 *   core.c     the handle, stopping a run, messages
 *   run.c      running until something stops it
 *   pins.c     levels put on pins, levels seen on pins
 *   uart.c     UART0's outer side
 *   mailbox.c  records in and out of a harness (see ../mailbox.h)
 *   max6675.c  thermocouple converters on bit-banged pins
 *   registers.c  converters with registers, which the firmware writes too
 *   counter.c  Timer 5 counting pulses
 *   encoder.c  an encoder's pulses
 *   wave.c     PWM signals from another controller
 *   eeprom.c   the EEPROM's contents, its write time, a write that is cut short
 *   mega.c     on top: the only one that knows all of them
 *
 * No file includes one that stands below it in this list, and none uses what it does not include. Names: gen_mega_* is
 * the face, mega_* is shared inside, the rest is file-local. New functions of the face raise GEN_MEGA_ABI.
 */
#ifndef GEN_MEGA_H
#define GEN_MEGA_H

#include "core.h"

#define GEN_MEGA_ABI 7

uint32_t gen_mega_abi(void);

/* NULL only when memory is short; else a handle, whose message tells what went wrong, if anything did. */
struct gen_mega *gen_mega_open(const char *elf, const char *mcu);
void gen_mega_close(struct gen_mega *mega);
const char *gen_mega_message(const struct gen_mega *mega);

/* How fast the watchdog's own oscillator runs, from when it is set next on: 128 000 Hz until told otherwise. */
int gen_mega_watchdog_hz(struct gen_mega *mega, uint32_t hz);
/* From now on a firmware that has gone astray does not end the run: an access behind the end of a memory finds or leaves a
 * byte that nothing else uses, an instruction that is none does nothing, and the program counter wraps.
 */
void gen_mega_astray(struct gen_mega *mega);

/* Reset the chip. MCUSR tells the firmware why: bit 0 power-on, 1 external, 2 brown-out, 3 watchdog. With power_lost
 * the SRAM holds noise afterwards, an EEPROM write under way is left half done, and off cycles pass before the reset.
 */
void gen_mega_reset(struct gen_mega *mega, uint8_t mcusr, int power_lost, uint64_t off, uint32_t seed);

/* Writes a boot loader to flash, which every reset, and the first start, then goes to; -1 where it does not fit. */
int gen_mega_boot_loader(struct gen_mega *mega, uint32_t address, const uint8_t *program, uint32_t size);

uint64_t gen_mega_cycle(const struct gen_mega *mega);
uint64_t gen_mega_asleep(const struct gen_mega *mega); /* cycles spent in a sleep mode */
uint64_t gen_mega_longest_awake(struct gen_mega *mega); /* in cycles, since it was asked for last */
uint32_t gen_mega_pc(const struct gen_mega *mega); /* in bytes */
uint16_t gen_mega_sp(const struct gen_mega *mega);
uint16_t gen_mega_ramend(const struct gen_mega *mega);
uint32_t gen_mega_resets(const struct gen_mega *mega);

/* Peek and poke see memory as it lies, without the side effects of an I/O register. 0 when it worked. */
int gen_mega_peek(const struct gen_mega *mega, uint32_t address, uint32_t count, uint8_t *to);
int gen_mega_poke(struct gen_mega *mega, uint32_t address, uint32_t count, const uint8_t *from);

/* Run until the cycle counter reaches limit, or until length bytes of pattern have left UART0 (none when 0).
 * Bytes sent before gen_mega_uart_forget() or up to the last match do not count. */
int gen_mega_run(struct gen_mega *mega, uint64_t limit, const uint8_t *pattern, size_t length);

/* Run, instruction by instruction, until the program counter (in bytes) stands at a place. */
int gen_mega_run_to(struct gen_mega *mega, uint64_t limit, uint32_t place);

#endif
