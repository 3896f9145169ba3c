#include "output.h"

#include "config.h"

namespace output {

namespace {

const uint16_t MASK = config::OUTPUT_BYTES - 1;

char buffer[config::OUTPUT_BYTES];
uint16_t head;  // next byte to put
uint16_t tail;  // next byte to send

const uint32_t powers[] PROGMEM = {1000000000UL, 100000000UL, 10000000UL, 1000000UL, 100000UL, 10000UL, 1000UL, 100UL, 10UL, 1UL};
const uint8_t POWERS = sizeof powers / sizeof powers[0];

// Digits by subtraction: a division of 32 bits takes 630 cycles, this 60 for a digit. The `last` powers are left out;
// `point` digits stand behind the decimal point.
void put_digits(uint32_t number, uint8_t last, uint8_t point) {
    bool leading = true;
    for (uint8_t i = 0; i < POWERS - last; ++i) {
        const uint32_t power = pgm_read_dword(&powers[i]);
        char digit = '0';
        while (number >= power) {
            number -= power;
            ++digit;
        }
        if (POWERS - last - i == point) {
            put('.');
        }
        leading = leading && digit == '0' && POWERS - last - i > point + 1;
        if (!leading) {
            put(digit);
        }
    }
}

uint32_t put_sign(int32_t number) {
    if (number < 0) {
        put('-');
        return 0 - (uint32_t)number;
    }
    return (uint32_t)number;
}

}  // namespace

uint16_t room() { return (uint16_t)(MASK - ((head - tail) & MASK)); }

bool takes_line() { return room() >= LINE_BYTES + config::ROW_BYTES; }

void put(char character) {
    if (room() == 0) {
        return;
    }
    buffer[head] = character;
    head = (head + 1) & MASK;
}

void put(const __FlashStringHelper *text) { put_name(reinterpret_cast<const char *>(text)); }

void put_name(const char *in_flash) {
    for (char c; (c = (char)pgm_read_byte(in_flash)) != 0; ++in_flash) {
        put(c);
    }
}

void put_number(int32_t number) { put_digits(put_sign(number), 0, 0); }

void put_thousandths(int32_t thousandths, uint8_t digits) { put_digits(put_sign(thousandths), (uint8_t)(3 - digits), digits); }

void put_hex(uint32_t number) {
    for (uint8_t i = 0; i < 8; ++i, number <<= 4) {
        const uint8_t digit = (uint8_t)(number >> 28);
        put((char)(digit < 10 ? '0' + digit : 'A' - 10 + digit));
    }
}

void end_line() {
    put('\r');
    put('\n');
}

bool drain() {
    for (int free = Serial.availableForWrite(); free > 0 && head != tail; --free) {
        Serial.write(buffer[tail]);
        tail = (tail + 1) & MASK;
    }
    return head == tail;
}

}  // namespace output
