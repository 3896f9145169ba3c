// Alarms that survive a reset: the latched ones are kept in EEPROM until somebody resets them.
//
// Every change goes to the next of 4 slots in turn, a byte at a time and before anything else is written, and is read back. A
// power cut in mid-write leaves the record before. A record counts only with the right identity (these rules) and CRC.
#ifndef LATCH_H
#define LATCH_H

#include <stdint.h>

namespace latch {

// Looks for the newest record; gives its alarms, 0 without one.
uint16_t begin();

// Once a sample: writes at most one byte of what has changed, without waiting.
void update(uint16_t alarms);

// True if the last record could not be written.
bool failed();

}  // namespace latch

#endif
