// Commands from the serial line, a line each; see the README.
#ifndef COMMANDS_H
#define COMMANDS_H

#include <stdint.h>

namespace commands {

// Takes what has arrived, and obeys what is complete.
void receive();

// Lines that were no command since the last take_rejected().
uint16_t rejected();
uint16_t take_rejected();

}  // namespace commands

#endif
