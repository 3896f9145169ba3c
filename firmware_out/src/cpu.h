// A test of the CPU's working registers and of its status register, in the spirit of IEC 60730 class B.
#ifndef CPU_H
#define CPU_H

#include <stdint.h>

namespace cpu {

// Whether r0..r31 hold two patterns, each with a value of its own for every register and the second with every bit the other
// way round, and SREG two of its own. What was in them is put back. Some 430 cycles without interrupts.
bool registers_hold();

}  // namespace cpu

#endif
