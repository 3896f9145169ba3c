// One probe a record, in the order of test_simulator.py's DATASHEET; the last record is an empty step.
#include "mailbox.h"
#include <stdint.h>

uint8_t gen_input;
uint8_t gen_output;

// Z points at a free cell of SRAM; the compiler puts nothing between two volatile asm statements without operands.
#define PROBE(code) \
    do { \
        __asm__ __volatile__("ldi r30, 0x00\n\tldi r31, 0x10" : : : "r30", "r31"); \
        GEN_MAILBOX_NEXT(); \
        __asm__ __volatile__(code : : : "r0", "r18", "r19", "r24", "r25", "memory"); \
        __asm__ __volatile__("clr r1"); \
        GEN_MAILBOX_DONE(); \
    } while (0)

int main() {
    gen_input = 0;
    gen_output = 0;
    PROBE("nop");
    PROBE("add r24, r25");
    PROBE("adiw r24, 1");
    PROBE("mul r24, r25");
    PROBE("muls r24, r25");
    PROBE("mulsu r18, r19");
    PROBE("movw r18, r24");
    PROBE("ld r18, Z");
    PROBE("ldd r18, Z+1");
    PROBE("st Z, r18");
    PROBE("lds r18, 0x1000");
    PROBE("push r18\n\tpop r18");
    PROBE("lpm r18, Z");
    PROBE("elpm r18, Z");
    PROBE("rjmp .+0");
    PROBE("call 1f\n\trjmp 2f\n1:\tret\n2:");
    PROBE("rcall 1f\n\trjmp 2f\n1:\tret\n2:");
    PROBE("sec\n\tbrcs .+0");
    PROBE("clc\n\tbrcs .+0");
    for (;;) {
        GEN_MAILBOX_NEXT();
        GEN_MAILBOX_DONE();
    }
}
