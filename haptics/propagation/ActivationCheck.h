#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"

#include <Eigen/Core>

#include <fmt/format.h>

namespace midair::haptics
{

/// Throws InputError if \a activations aren't one for each transducer of \a array.
inline void checkActivations(const TransducerArray& array, const Eigen::VectorXcf& activations)
{
    if (activations.size() != array.size())
        throw base::InputError(fmt::format(
            "activations are {}; there must be one for each of the array's {} transducers",
            activations.size(),
            array.size()));
}

} // namespace midair::haptics
