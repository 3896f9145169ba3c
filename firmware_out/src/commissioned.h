// Whether somebody has commissioned this wiring: one record in EEPROM, with the wiring's identity and a CRC.
//
// A byte is written in a sample, without waiting. A power cut in mid-write, or a bit that turns, leaves "not commissioned".
// Firmware of another coefficient file for the same wiring takes it over; with other pins or channels it is not this record.
#ifndef COMMISSIONED_H
#define COMMISSIONED_H

#include <stdint.h>

namespace commissioned {

// Looks for the record.
void begin();

// As the EEPROM says: false from the moment in which something else is to be written.
bool passed();

// Begins to write that it was passed, or that it was not.
void set(bool passed);

// Once a sample: writes one byte, or compares what was written.
void sample();

// False once what was set is there, or has failed to be.
bool busy();

}  // namespace commissioned

#endif
