// Runs a rival on this computer: records in, the rises after each out.
#include "rival.h"
#include <stdio.h>

#pragma pack(push, 1)
struct Input {
    uint8_t op;
    int16_t pwm;
    int32_t start_mK;
};
#pragma pack(pop)

RIVAL_WORD rival_rise[RIVAL_PARTS];

int main() {
    Input input;
    rival_begin();
    while (fread(&input, sizeof input, 1, stdin) == 1) {
        if (input.op) {
            rival_begin();
        } else {
            rival_step(input.pwm);
        }
        if (fwrite(rival_rise, sizeof rival_rise, 1, stdout) != 1) {
            return 1;
        }
    }
    return 0;
}
