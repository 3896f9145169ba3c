// Copies of the model's states in EEPROM, so that the model goes on after a reset.
//
// Each copy goes to the next of 62 slots in turn, a byte at a time: a power cut in mid-write leaves the one before it. A copy
// counts only with the right identity (coefficients, arithmetic, version) and CRC, and is used only if the measured
// temperatures are where they were when it was made. With a copy every 600 s, a byte of EEPROM sees its 100 000 erase and
// write cycles in 118 years.
#ifndef MEMORY_H
#define MEMORY_H

#include <stdint.h>

namespace memory {

// Looks for the newest copy. `firmware` is the CRC of the program in flash.
void begin(uint32_t firmware);

// Puts the newest copy into the model if it is still true; false if there is none or it is not.
bool resume();

// Once a sample: makes a copy when it is due, and writes one byte of it, without waiting.
void update();

// True if the last copy could not be written.
bool failed();

// True if the firmware's CRC is another than at the last start (or the EEPROM knew none).
bool firmware_is_new();

// For the self test: true if a slot (0..61) holds a valid copy; some 9 000 cycles.
bool valid(uint16_t slot);

}  // namespace memory

#endif
