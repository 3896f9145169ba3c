// Commands from the serial line, a line each; see the README.
#ifndef COMMANDS_H
#define COMMANDS_H

#include <stdint.h>

namespace commands {

// Takes what has arrived, and obeys what is complete.
void receive();

// What the command `reset` does, and the button: the alarms end, and what protects ends as far as it may.
void reset();

// A thermocouple's name as commands have it, a string in flash.
const char *channel_name(uint8_t channel);

// Once a sample. How many of them have passed since a line was obeyed.
void sample();
uint16_t samples_silent();

// Lines that were no command since the last take_rejected().
uint16_t rejected();
uint16_t take_rejected();

}  // namespace commands

#endif
