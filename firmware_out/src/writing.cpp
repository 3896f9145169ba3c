#include "writing.h"

#include <avr/eeprom.h>

void Writing::begin(const void *what, uint16_t size, uint16_t where) {
    from_ = static_cast<const uint8_t *>(what);
    to_ = where;
    left_ = size;
}

void Writing::go_on() {
    while (left_ > 0) {
        uint8_t *const at = reinterpret_cast<uint8_t *>(to_);
        const uint8_t byte = *from_;
        ++to_;
        ++from_;
        --left_;
        if (eeprom_read_byte(at) != byte) {
            eeprom_write_byte(at, byte);
            return;
        }
    }
}
