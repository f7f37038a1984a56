#pragma once

#include "engine-bridge/playing/PressureCap.h"

#include <Eigen/Core>

#include <vector>

namespace midair::bridge
{

/// Returns the maximum of |f_0 p_0 + f_1 p_1 + ..| over all f in [0, 1] for each row of \a p
/// (points times parts of an array), or an upper bound.
Eigen::VectorXf mostOfParts(const Eigen::Ref<const Eigen::MatrixXcf>& p);

/// Upper bounds on the pressure of fields at the points of a cap, for any combination of the
/// array's parts. Data of the places is computed once, and each row of the propagation matrix once
/// for all fields of a call.
class FieldBounds
{
public:
    /// Keeps references to everything in \a where. \a known: a field of the first array with known
    /// pressures, see haptics::FieldSequence::achieved_Pa; fields proportional to it need no
    /// matrix. Empty: none.
    FieldBounds(const CappedPlaces& where,
                const device::DriveAbility& ability,
                CappedField known = {});

    /// True if amplitudes may be lowered after the cap was applied.
    bool isLowered() const { return _where.modulated || _ability.fades; }
    const CappedPlaces& where() const { return _where; }

    /// Returns for each of \a fields (K times m, as played) a bound on the pressure at the loudest
    /// point for any of the arrays, Pa, or NaN. \a rounding: for each field the largest change of
    /// an amplitude when it is lowered and rounded; 0 if only the field's level changes. \a
    /// achieved_Pa (n x K): |G q| for the first array. Bounds up to \a enough_Pa needn't be tight;
    /// for the known field over it, the exact pressure is returned. Throws base::Stopped.
    std::vector<double> of(const std::vector<Eigen::VectorXcf>& fields,
                           const std::vector<float>& rounding,
                           Eigen::MatrixXf& achieved_Pa,
                           double enough_Pa = -1.0) const;

private:
    Eigen::MatrixXcf pressureOfParts(const haptics::TransducerArray& array,
                                     const std::vector<Eigen::VectorXcf>& fields) const;
    Eigen::MatrixXf boundsOf(const haptics::TransducerArray& array,
                             const Eigen::VectorXf& norm_Pa,
                             const Eigen::MatrixXcf& p,
                             const std::vector<Eigen::VectorXcf>& fields,
                             const std::vector<float>& rounding) const;
    const Eigen::VectorXf& normOf(std::size_t array) const;
    const Eigen::VectorXf& looseNormOf(std::size_t array) const;
    bool boundByKnown(const std::vector<Eigen::VectorXcf>& fields,
                      const std::vector<float>& rounding,
                      double enough_Pa,
                      Eigen::MatrixXf& achieved_Pa,
                      double& most_Pa) const;

    const CappedPlaces& _where;
    const device::DriveAbility& _ability;
    CappedField _known;
    Eigen::Index _parts = 1;
    /// For each array (n): times the 2-norm of the amplitudes an upper bound of the in-phase sum;
    /// computed on demand, because it takes as long as the field.
    mutable std::vector<Eigen::VectorXf> _norm_Pa;
    mutable std::vector<Eigen::VectorXf> _looseNorm_Pa; ///< quick upper bounds on these
};

} // namespace midair::bridge
