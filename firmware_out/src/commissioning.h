// Commissioning: the board and the person who wired it go through what the board cannot know alone, which thermocouple is which,
// their polarity, the direction of rotation, the encoder, and that the motor stops. The README tells the person's part.
//
// Every failure ends it, and so does every line that is not part of it. It never goes on after a reset.
#ifndef COMMISSIONING_H
#define COMMISSIONING_H

#include <stdint.h>

namespace commissioning {

// The command `commission`. From here on the board counts as not commissioned until the end is reached.
void start();

// The commands `yes` and `no`. False while it does not run.
bool answer(bool yes);

// Something else was commanded: ends it, with the motor at PWM 0. Nothing happens while it does not run.
void end();

// True while the motor is the dialogue's own: nobody else can command it without ending the dialogue.
bool drives();

// Once a sample, before what protects.
void sample();

}  // namespace commissioning

#endif
