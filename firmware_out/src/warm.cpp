#include "warm.h"

#include <my1016_alarms_state.h>
#include <my1016_protection.h>
#include <my1016_sensors_state.h>
#include <stddef.h>
#include <string.h>

#include "board.h"
#include "config.h"
#include "snapshot.h"

namespace warm {

namespace {

struct Record {
    uint32_t identity;
    uint32_t number;  // one more with every sample: the higher is the newer
    snapshot::Snapshot snapshot;
    my1016_AlarmState alarms;
    my1016_ProtectionState protection;
    my1016_Sensor sensors[MY1016_SENSORS];
    uint32_t sum;  // of all before it
};

Record records[2] __attribute__((section(".noinit")));
const Record *newest;  // null: none
uint32_t identity;
uint32_t number;

// Fletcher's sum of words (IEEE Trans. Commun. 30, 1982), 16 bits each: some 6 cycles a byte, where the EEPROM's CRC-32 takes 130.
// Any single bit that turns changes the lower half.
uint32_t sum_of(const Record &of) {
    const uint8_t *const bytes = reinterpret_cast<const uint8_t *>(&of);
    uint16_t sum = 0xFFFF, sums = 0, i = 0;
    for (; i + 1 < offsetof(Record, sum); i += 2) {
        uint16_t word;
        memcpy(&word, bytes + i, sizeof word);
        sum = (uint16_t)(sum + word);
        sums = (uint16_t)(sums + sum);
    }
    if (i < offsetof(Record, sum)) {  // one is left
        sum = (uint16_t)(sum + bytes[i]);
        sums = (uint16_t)(sums + sum);
    }
    return (uint32_t)sums << 16 | sum;
}

bool is_sound(const Record &record) { return record.identity == identity && record.sum == sum_of(record); }

}  // namespace

void begin(uint32_t firmware) {
    identity = config::COPY_IDENTITY ^ firmware;
    newest = nullptr;
    if (!board::kept_ram()) {
        return;
    }
    for (const Record &record : records) {
        if (is_sound(record) && (newest == nullptr || (int32_t)(record.number - newest->number) > 0)) {
            newest = &record;
        }
    }
    if (newest != nullptr) {
        number = newest->number;
        my1016_alarms_restore(newest->alarms.latched);
        my1016_protection_state = newest->protection;
    }
}

bool resume() {
    if (newest == nullptr || !snapshot::is_true(newest->snapshot)) {
        return false;
    }
    snapshot::put(newest->snapshot);
    const uint16_t latched = my1016_alarms();  // somebody may have ended some of them since the reset
    my1016_alarm_state = newest->alarms;
    my1016_alarm_state.latched = latched;
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        my1016_sensors_restore(channel, &newest->sensors[channel]);
    }
    return true;
}

void keep() {
    newest = nullptr;  // it is not looked for again
    Record *const record = &records[++number & 1u];
    record->identity = identity;
    record->number = number;
    snapshot::take(&record->snapshot);
    record->alarms = my1016_alarm_state;
    record->protection = my1016_protection_state;
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        record->sensors[channel] = my1016_sensors[channel];
    }
    record->sum = sum_of(*record);
}

}  // namespace warm
