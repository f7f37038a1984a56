#pragma once

#include "haptics/array/Reflector.h"

#include <Eigen/Core>

#include <complex>
#include <vector>

namespace midair::haptics
{

/// The effect of flat reflectors on sound, by image sources. A reflector adds the wave of the
/// mirror image of a transducer for points on the transducer's side, times \c reflection, and takes
/// the same part of the direct wave from points on the other side, as a thin sheet does, whose
/// velocity is the same on both sides. Its ends count by the Fresnel integrals of a rectangular
/// opening (Born, Wolf, "Principles of Optics", section 8.7), so that the field has no jump beside
/// it. Waves that several reflectors reflect one after the other are left out. A board of the array
/// does so to the sound of the transducers of other boards.

/// Returns F(v) = (1 + j)/2 int_{-inf}^v exp(-j pi u^2 / 2) du, the share of a wave beyond a
/// straight edge: 0 at -inf, 1/2 at 0, 1 at inf. Error below 1e-13.
std::complex<double> shareBeyondEdge(double v);

/// Returns the share w of a wave that \a reflector turns on its way \a from a transducer \a to a
/// point, or takes away if they are on different sides: 1 well inside its shadow or its mirror, 0
/// well outside, (1 for planes without end). Symmetric in both places, finite everywhere.
///     w = prod_e [F(v_e+) - F(v_e-)],
///     v_e+- = (+-h_e - X.e) sqrt((2/lambda) (1/r1 + 1/r2) (1 - (d.e)^2))
/// with X where the path meets the plane, seen from the centre, r1 and r2 its two parts, d its
/// direction as if it went straight on, e along and across, h_e half of the sides.
std::complex<double> shareTurned(const Reflector& reflector,
                                 const Eigen::Vector3d& from,
                                 const Eigen::Vector3d& to,
                                 double wavelength_m);

/// Returns true if \a reflector sends sound of a transducer at \a from back to \a to: both are on
/// one side of its plane.
inline bool
isReflected(const Reflector& reflector, const Eigen::Vector3d& from, const Eigen::Vector3d& to)
{
    return reflector.reflection != 0.0 && !reflector.carries(from) &&
           (reflector.heightOf(from) >= 0.0) == (reflector.heightOf(to) >= 0.0);
}

/// Returns true if \a reflector takes from the sound of a transducer at \a from that goes to \a to,
/// on the other side of its plane.
inline bool
isShaded(const Reflector& reflector, const Eigen::Vector3d& from, const Eigen::Vector3d& to)
{
    return reflector.reflection != 0.0 && !reflector.carries(from) &&
           (reflector.heightOf(from) >= 0.0) != (reflector.heightOf(to) >= 0.0);
}

/// Returns the factor of reflected waves, R exp(j phase).
inline std::complex<double> factorOf(const Reflector& reflector)
{
    return std::polar(reflector.reflection, reflector.reflectionPhase_rad);
}

/// Calls \a take(entry, place) for each way of sound from \a from to \a to: first for the direct
/// one, with what is left of it, then for those to the images of \a to. \a wave(place): the entry
/// of the free field there.
template<typename Wave, typename Take>
void forEachPath(const std::vector<Reflector>& reflectors,
                 const Eigen::Vector3d& from,
                 const Eigen::Vector3d& to,
                 double wavelength_m,
                 const Wave& wave,
                 const Take& take)
{
    std::complex<double> direct = wave(to);
    for (const Reflector& one : reflectors)
        if (isShaded(one, from, to))
            direct *= 1.0 - one.reflection * shareTurned(one, from, to, wavelength_m);
    take(direct, to);
    for (const Reflector& one : reflectors)
    {
        if (!isReflected(one, from, to)) continue;
        const Eigen::Vector3d image = one.mirrored(to);
        take(factorOf(one) * shareTurned(one, from, to, wavelength_m) * wave(image), image);
    }
}

} // namespace midair::haptics
