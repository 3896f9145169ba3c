// The motor's driver: a PWM pin for each direction, never both.
#ifndef DRIVE_H
#define DRIVE_H

#include <stdint.h>

namespace drive {

void begin();

// Takes a command, to be applied at the next sample. False if it is not taken.
bool command(int16_t pwm);

// Once a sample: what acts from now until the next one. `stop` holds PWM 0.
void update(bool stop);

// What acts now.
int16_t pwm();

}  // namespace drive

#endif
