#pragma once

#include "haptics/array/Reflector.h"
#include "haptics/base/AlignedBuffer.h"
#include "haptics/propagation/kernels/ReflectionKernels.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Reflectors in the layout of the kernels: where each lane of a PropagationMatrix lies beside
/// them. Lengths are in wavelengths.
class SheetGeometry
{
public:
    /// \a places: 3 x lanes, wavelengths; \a padded: length of a vector over lanes. Reflectors of
    /// reflection 0 are left out. Lanes of transducers that stand on a board get the height 0.
    void bind(const std::vector<Reflector>& reflectors,
              const Eigen::Matrix3Xd& places,
              int padded,
              double wavelength_m);

    int size() const { return static_cast<int>(_sheets.size()); }
    /// Returns the mirror image of \a x in reflector \a k.
    Eigen::Vector3d mirrored(int k, const Eigen::Vector3d& x) const
    {
        return _sheets[static_cast<std::size_t>(k)].mirrored(x);
    }
    const Reflector& sheet(int k) const { return _sheets[static_cast<std::size_t>(k)]; }
    /// Returns true if all lanes first .. first + width - 1 are in front of reflector \a k, or
    /// behind it, and none stands on it.
    bool isWhollyBeside(int k, bool inFront, int first, int width) const;
    /// Returns reflector \a k and its lanes from \a first on for kernels; for one with ends.
    kernels::SheetView view(int k, int first) const;
    /// Returns \a x as reflector \a k sees it.
    kernels::SheetPoint seen(int k, const Eigen::Vector3d& x) const;
    /// Returns true if reflector \a k sends waves of some lane \a first .. first + width - 1 is on
    /// the side of \a x.
    bool isReflecting(int k, const Eigen::Vector3d& x, int first, int width) const;
    /// Adds what reflector \a k does to the waves at \a x of the lanes first .. first + width - 1
    /// (first: a multiple of kernels::kLanes); \a row has no heights yet.
    void reflect(int k, const Eigen::Vector3d& x, int first, int width, kernels::Waves row) const;

private:
    const float* lanes(int k, int axis) const
    {
        return _lanes.data() + std::size_t(3 * k + axis) * static_cast<std::size_t>(_padded);
    }

    std::vector<Reflector> _sheets;    ///< in wavelengths
    base::AlignedBuffer<float> _lanes; ///< of each reflector heights, along, across
    int _padded = 0;
};

} // namespace midair::haptics
