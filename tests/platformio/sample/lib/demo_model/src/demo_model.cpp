#include "demo_model.h"

namespace demo_model {

int32_t Model::step(uint8_t pwm) {
  const int32_t target = static_cast<int32_t>(pwm) << 16;
  state_ += (target - state_) / 16;
  return state_;
}

}  // namespace demo_model
