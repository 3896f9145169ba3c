// Bytes on their way into EEPROM: one at a time, without waiting, and none that is there already.
#ifndef WRITING_H
#define WRITING_H

#include <stdint.h>

class Writing {
  public:
    // Begins to write `size` bytes to an address; they must stay as they are until all are written.
    void begin(const void *what, uint16_t size, uint16_t where);

    // Writes the next byte that differs. Call it only while the EEPROM is ready.
    void go_on();

    bool done() const { return left_ == 0; }

  private:
    const uint8_t *from_;
    uint16_t to_;
    uint16_t left_;
};

#endif
