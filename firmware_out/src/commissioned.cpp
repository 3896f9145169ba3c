#include "commissioned.h"

#include <avr/eeprom.h>
#include <stddef.h>

#include "config.h"
#include "crc32.h"

namespace commissioned {

namespace {

const uint8_t PASSED = 0xA5, NOT_PASSED = 0x00;  // no single bit makes one of the other, or either of an empty cell

struct Record {
    uint32_t wiring;
    uint8_t verdict;
    uint32_t crc;  // of all before it
};
static_assert(sizeof(Record) == config::COMMISSIONED_BYTES, "its place was counted for another size");

Record record;  // being written
uint8_t left;   // bytes of it still to write
bool checking;  // it is written and is to be read again
bool is_passed;

uint8_t *place(uint8_t at) { return reinterpret_cast<uint8_t *>(config::COMMISSIONED_AT + at); }

uint32_t crc_of(const Record &of) { return crc32_of(&of, offsetof(Record, crc)); }

bool kept() {
    Record found;
    eeprom_read_block(&found, place(0), sizeof found);
    return found.wiring == config::COMMISSIONED_WIRING && found.verdict == PASSED && found.crc == crc_of(found);
}

// Bytes that are right already cost nothing.
void write_on() {
    while (left > 0) {
        uint8_t *const at = place((uint8_t)(sizeof record - left));
        const uint8_t byte = reinterpret_cast<const uint8_t *>(&record)[sizeof record - left];
        --left;
        if (eeprom_read_byte(at) != byte) {
            eeprom_write_byte(at, byte);
            return;
        }
    }
}

}  // namespace

void begin() { is_passed = kept(); }

bool passed() { return is_passed; }

void set(bool passed) {
    is_passed = false;
    record.wiring = config::COMMISSIONED_WIRING;
    record.verdict = passed ? PASSED : NOT_PASSED;
    record.crc = crc_of(record);
    left = sizeof record;
    checking = true;
}

void sample() {
    if (!checking || !eeprom_is_ready()) {
        return;
    }
    if (left > 0) {
        write_on();
    } else {
        checking = false;
        is_passed = kept();
    }
}

bool busy() { return checking; }

}  // namespace commissioned
