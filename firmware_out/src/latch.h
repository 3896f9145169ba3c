// What survives a reset: latched alarms, and what only a command ends, are kept in EEPROM until somebody ends them.
//
// Every change goes to the next two of 4 slots in turn, a byte as soon as the one before is done and before anything else is written, and is read back. A
// power cut in mid-write leaves the record before, and a bit that turns in one of the two leaves the other. A record counts only with the right identity (these rules) and CRC.
#ifndef LATCH_H
#define LATCH_H

#include <stdint.h>

namespace latch {

// Looks for the newest record.
void begin();

// What it holds, 0 without one: a mask of alarms, and one of what protects.
uint16_t alarms();
uint32_t protection();

// Once a sample: sees what has changed, and whether what was written is there.
void update(uint16_t alarms, uint32_t protection);

// Between the samples: writes at most one byte, without waiting. True while there are more: whoever resets a board that has
// just stopped its motor must find it stopped.
bool work();

// True if the last record could not be written.
bool failed();

}  // namespace latch

#endif
