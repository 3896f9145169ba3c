// The MAX6675s: one word of each, as it comes.
#ifndef THERMOCOUPLES_H
#define THERMOCOUPLES_H

#include <stdint.h>

namespace thermocouples {

void begin();

// Reads a chip's 16 bits, in the order of the coefficient file. A new conversion begins at the end of the reading.
uint16_t read(uint8_t chip);

}  // namespace thermocouples

#endif
