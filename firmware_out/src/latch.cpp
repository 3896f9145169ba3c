#include "latch.h"

#include <avr/eeprom.h>
#include <stddef.h>

#include "config.h"
#include "crc32.h"
#include "writing.h"

namespace latch {

namespace {

struct Record {
    uint32_t identity;
    uint32_t number;  // one more with every record: the highest is the newest
    uint16_t alarms;
    uint32_t protection;
    uint32_t crc;  // of all before it
};
static_assert(sizeof(Record) == config::LATCH_BYTES, "slots were counted for another size");

Record record;  // the newest, or the one being written
uint8_t slot;   // its place
Writing writing;
bool checking;  // it is written and is to be read again
bool again;     // .. and then to be written a second time: a bit that turns in one leaves the other
bool failure;

uint16_t address(uint8_t of_slot) { return (uint16_t)(config::LATCH_AT + of_slot * sizeof(Record)); }

uint32_t crc_of(const Record &of) { return crc32_of(&of, offsetof(Record, crc)); }

bool fetch(uint8_t of_slot, Record *to) {
    eeprom_read_block(to, reinterpret_cast<const void *>(address(of_slot)), sizeof *to);
    return to->identity == config::COPY_IDENTITY && to->number != 0 && to->crc == crc_of(*to);
}

void into_next_slot() {
    slot = (uint8_t)(slot + 1 == config::LATCH_SLOTS ? 0 : slot + 1);
    writing.begin(&record, sizeof record, address(slot));
    checking = true;
}

void make(uint16_t alarms, uint32_t protection) {
    record.identity = config::COPY_IDENTITY;
    ++record.number;
    record.alarms = alarms;
    record.protection = protection;
    record.crc = crc_of(record);
    again = true;
    into_next_slot();
}

}  // namespace

void begin() {
    record = Record();
    Record found;
    for (uint8_t i = 0; i < config::LATCH_SLOTS; ++i) {
        if (fetch(i, &found) && found.number > record.number) {
            record = found;
            slot = i;
        }
    }
}

uint16_t alarms() { return record.alarms; }

uint32_t protection() { return record.protection; }

void update(uint16_t alarms, uint32_t protection) {
    if (!writing.done() || !eeprom_is_ready()) {
        return;
    }
    if (checking) {
        Record found;
        checking = false;
        failure = !fetch(slot, &found) || found.number != record.number;
        if (failure) {
            make(alarms, protection);
        } else if (again) {
            again = false;
            into_next_slot();
        }
    } else if (alarms != record.alarms || protection != record.protection) {
        make(alarms, protection);
    }
}

bool work() {
    if (!writing.done() && eeprom_is_ready()) {
        writing.go_on();
    }
    return !writing.done();
}

bool failed() { return failure; }

}  // namespace latch
