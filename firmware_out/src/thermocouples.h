// The sensors' chips: the bits of each, as they come.
#ifndef THERMOCOUPLES_H
#define THERMOCOUPLES_H

#include <stdint.h>

namespace thermocouples {

void begin();

// Reads a chip, in the order of the coefficient file. Where reading stops a conversion, a new one begins at its end.
uint32_t read(uint8_t chip);

}  // namespace thermocouples

#endif
