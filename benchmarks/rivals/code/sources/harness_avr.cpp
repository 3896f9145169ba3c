// Runs a rival on the emulated board, as gen's own harness runs the emitted library.
#include "mailbox.h"
#include "rival.h"
#include <avr/interrupt.h>

struct Input {
    uint8_t op;
    int16_t pwm;
    int32_t start_mK;
};
// The emulator writes one and reads the other: they keep their names, also where all is optimised at link time.
__attribute__((externally_visible)) Input gen_input;
__attribute__((externally_visible)) RIVAL_WORD rival_rise[RIVAL_PARTS];

int main() {
    cli();
    rival_begin();
    for (;;) {
        GEN_MAILBOX_NEXT();
        if (gen_input.op) {
            rival_begin();
        } else {
            rival_step(gen_input.pwm);
        }
        GEN_MAILBOX_DONE();
    }
}
