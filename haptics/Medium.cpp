#include "haptics/Medium.h"

#include <cmath>

namespace midair::haptics
{

double Medium::soundSpeed() const { return 331.3 * std::sqrt(1.0 + temperature_C / 273.15); }

} // namespace midair::haptics
