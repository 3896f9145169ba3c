// Text for the serial line: it waits in a buffer of its own, so that nobody has to wait for the line.
#ifndef OUTPUT_H
#define OUTPUT_H

#include <Arduino.h>

namespace output {

// No line but a row and the header's last one is longer.
const uint8_t LINE_BYTES = 110;

// Bytes that can be put now. Whoever writes a line asks first, and leaves it if there is no room.
uint16_t room();

// Whether a line can be put that is not a row, with room left for the next row: rows come first.
bool takes_line();

void put(char character);
void put(const __FlashStringHelper *text);
void put_name(const char *in_flash);
void put_number(int32_t number);
void put_hex(uint32_t number);

// Thousandths as a decimal number with 3 digits after the point, or 2.
void put_thousandths(int32_t thousandths, uint8_t digits = 3);

void end_line();

// Passes on to the UART what it takes at once. True if nothing is left.
bool drain();

}  // namespace output

#endif
