// The motor's driver: a PWM pin for each direction, never both.
#ifndef DRIVE_H
#define DRIVE_H

#include <stdint.h>

namespace drive {

void begin();

// Takes a command, to be applied at the next sample. False if it is not taken.
bool command(int16_t pwm);

// A PWM other than 0 has to be armed first, after each start, each stop and each line that was no command. arm() is false,
// and nothing is armed, while the motor has to stand. The caller of command() asks armed().
bool arm();
void disarm();
bool armed();

// True while a PWM other than 0 acts because a line commanded it.
bool follows_line();

// Once a sample: what acts from now until the next one, at most `most`; 0 stops the motor, and disarms.
void update(uint8_t most);

// What acts now.
int16_t pwm();

}  // namespace drive

#endif
