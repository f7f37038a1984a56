#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/scattering/Gmres.h"

#include <Eigen/Core>

namespace midair::haptics
{

/// The field of an array, without what stands in it, at places of a surface.
struct IncidentField
{
    Eigen::VectorXcd pressure_Pa; ///< n, complex peak pressure
    Eigen::VectorXcd slope_Pa_m;  ///< n, its derivative along the normal
};

/// Returns the field of \a activations (m, |q| = 1 is full drive) at \a places (3 x n, metres) with
/// \a normals (3 x n, unit length), on \a threads threads. The slope is a difference of fourth
/// order over a tenth of a wavelength; its error is below 0.1 % of k |p| where the field is
/// regular. Throws as pressureAt() does.
IncidentField incidentField(const Eigen::Matrix3Xd& places,
                            const Eigen::Matrix3Xd& normals,
                            const TransducerArray& array,
                            const Medium& medium,
                            const Eigen::VectorXcf& activations,
                            int threads = 1,
                            const base::StopToken& stop = {});

/// A rigid thing in the field. Convention: e^{+j w t}, waves e^{-jkr}/r, as everywhere in the kit.
class Scatterer
{
public:
    virtual ~Scatterer() = default;

    /// Centres of the elements (3 x n, metres), where the incident field is needed.
    virtual const Eigen::Matrix3Xd& places() const = 0;
    /// Unit normals there, 3 x n.
    virtual const Eigen::Matrix3Xd& normals() const = 0;
    /// Solves for the source strength of each element (n). Throws Stopped.
    virtual GmresReport solve(const IncidentField& incident,
                              Eigen::VectorXcd& strength,
                              const base::StopToken& stop = {}) const = 0;
    /// Returns the scattered pressure, Pa, of \a strength at \a points (3 x p, metres): what the
    /// thing adds to the incident field.
    virtual Eigen::VectorXcd scattered(const Eigen::Matrix3Xd& points,
                                       const Eigen::VectorXcd& strength,
                                       int threads = 1) const = 0;
    /// Returns a rough model of scattered() as a matrix (p x m): the pressure, Pa, at each of \a
    /// points (3 x p, metres) for each activation of \a array. Empty: there is none. Throws
    /// Stopped.
    virtual Eigen::MatrixXcf optics(const Eigen::Matrix3Xd& /*points*/,
                                    const TransducerArray& /*array*/,
                                    const Medium& /*medium*/,
                                    int /*threads*/ = 1,
                                    const base::StopToken& /*stop*/ = {}) const
    {
        return {};
    }
    /// Returns true for a place (metres) inside, where there is no field.
    virtual bool isInside(const Eigen::Vector3d& /*place*/) const { return false; }
};

} // namespace midair::haptics
