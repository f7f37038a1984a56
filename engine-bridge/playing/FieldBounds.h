#pragma once

#include "engine-bridge/playing/PressureCap.h"

#include <Eigen/Core>

#include <vector>

namespace midair::bridge
{

/// Returns the largest |f_0 p_0 + f_1 p_1 + ..| over all f in [0, 1] for each row of \a p (points
/// times parts of an array), or an upper bound.
Eigen::VectorXf mostOfParts(const Eigen::Ref<const Eigen::MatrixXcf>& p);

/// Upper bounds on the pressure of fields at the points where a cap must hold, whichever parts of
/// the array sound. What depends on the places alone is computed once, and each row of the
/// propagation matrix once for all fields that are asked for together.
class FieldBounds
{
public:
    /// Keeps references to all that \a where names. \a known: a field of the first array whose
    /// pressures are known, as haptics::FieldSequence::achieved_Pa; what is in proportion to it
    /// needs no matrix. Empty: none.
    FieldBounds(const CappedPlaces& where,
                const device::DriveAbility& ability,
                CappedField known = {});

    /// True if amplitudes may be lowered after the cap was held.
    bool isLowered() const { return _where.modulated || _ability.fades; }
    const CappedPlaces& where() const { return _where; }

    /// Returns for each of \a fields (K times m, as played) a bound on the pressure at the loudest
    /// point for any of the arrays, Pa, or NaN. \a rounding: for each field the most that an
    /// amplitude of it changes when it is lowered and rounded; 0 if the field stays the same but
    /// for its level. \a achieved_Pa (n x K): |G q| for the first of the arrays. Bounds that are at
    /// most \a enough_Pa needn't be close; of the known field that is over it, the pressure itself.
    /// Throws base::Stopped.
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
    /// For each array (n): times the 2-norm of the amplitudes at least what is heard in phase;
    /// empty until it is asked for, since it takes as long as the field.
    mutable std::vector<Eigen::VectorXf> _norm_Pa;
    mutable std::vector<Eigen::VectorXf> _looseNorm_Pa; ///< upper bounds on these, quickly found
};

} // namespace midair::bridge
