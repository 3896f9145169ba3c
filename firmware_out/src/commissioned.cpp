#include "commissioned.h"

#include <avr/eeprom.h>
#include <stddef.h>

#include "config.h"
#include "crc32.h"
#include "writing.h"

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
Writing writing;
bool checking;  // it is written and is to be read again
bool is_passed;

uint32_t crc_of(const Record &of) { return crc32_of(&of, offsetof(Record, crc)); }

bool kept() {
    Record found;
    eeprom_read_block(&found, reinterpret_cast<const void *>(config::COMMISSIONED_AT), sizeof found);
    return found.wiring == config::WIRING && found.verdict == PASSED && found.crc == crc_of(found);
}

}  // namespace

void begin() { is_passed = kept(); }

bool passed() { return is_passed; }

void set(bool passed) {
    is_passed = false;
    record.wiring = config::WIRING;
    record.verdict = passed ? PASSED : NOT_PASSED;
    record.crc = crc_of(record);
    writing.begin(&record, sizeof record, config::COMMISSIONED_AT);
    checking = true;
}

void sample() {
    if (!checking || !eeprom_is_ready()) {
        return;
    }
    if (!writing.done()) {
        writing.go_on();
    } else {
        checking = false;
        is_passed = kept();
    }
}

bool busy() { return checking; }

}  // namespace commissioned
