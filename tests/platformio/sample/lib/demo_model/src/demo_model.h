#pragma once

#include <stdint.h>

namespace demo_model {

/// First-order lag: the state follows `pwm << 16` by a sixteenth of the distance at every step.
class Model {
 public:
  int32_t step(uint8_t pwm);

 private:
  int32_t state_ = 0;
};

}  // namespace demo_model
