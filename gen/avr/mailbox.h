/* The firmware's side of EmulatedMega.run_records (see shim/mailbox.c): two marks in GPIOR0.
 *
 *     for (;;) {
 *         GEN_MAILBOX_NEXT();     // the emulator writes the next record into the input variable
 *         output = step(input);   // globals or volatile: both marks are compiler barriers
 *         GEN_MAILBOX_DONE();     // the emulator reads the output variable and the cycle counter
 *     }
 *
 * Between the two marks stand the step and exactly GEN_MAILBOX_OVERHEAD cycles: the OUT of the first mark and the LDI
 * of the second. Keep interrupts off: their cycles would be counted, and simavr enters them in 0 cycles, not 5.
 */
#ifndef GEN_MAILBOX_H
#define GEN_MAILBOX_H

#define GEN_MAILBOX_OVERHEAD 2

#define GEN_MAILBOX_MARK(mark) __asm__ __volatile__("ldi r24, %0\n\tout 0x1e, r24" : : "M"(mark) : "r24", "memory")
#define GEN_MAILBOX_NEXT() GEN_MAILBOX_MARK(1)
#define GEN_MAILBOX_DONE() GEN_MAILBOX_MARK(2)

#endif
