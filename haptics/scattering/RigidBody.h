#pragma once

#include "haptics/scattering/ClosedBody.h"
#include "haptics/scattering/Scatterer.h"

namespace midair::haptics
{

/// The field of a rigid closed body: the pressure on it, constant on each triangle, by the equation
/// of Burton and Miller (1971, 10.1098/rspa.1971.0097), which has one solution at all frequencies.
/// The matrix is dense, in single precision.
class RigidBody : public Scatterer
{
public:
    static constexpr double kElements = 6.0;             ///< an edge's wavelength over its length
    static constexpr double kResidual = 1e-4;            ///< of the equations
    static constexpr Eigen::Index kMostElements = 10000; ///< 0.8 GB

    /// Divides \a mesh for \a wavelength_m (> 0). \a elementsPerWavelength: 6 give about 1 %, 4 2
    /// to 3 %. Throws as ClosedBody::from().
    static ClosedBody divided(const TriangleMesh& mesh,
                              double wavelength_m,
                              double elementsPerWavelength = kElements);

    /// Makes the matrix of \a body, on \a threads threads: a minute on two for kMostElements.
    /// Throws Stopped if \a stop requests it.
    RigidBody(ClosedBody body,
              double wavelength_m,
              int threads = 1,
              const base::StopToken& stop = {});

    /// Bytes that a body of \a elements takes, to be told beforehand.
    static double bytesFor(Eigen::Index elements);

    const ClosedBody& body() const { return _body; }
    const Eigen::Matrix3Xd& places() const override { return _body.centres; }
    const Eigen::Matrix3Xd& normals() const override { return _body.normals; }
    /// The strengths are the pressures on the body, Pa.
    GmresReport solve(const IncidentField& incident,
                      Eigen::VectorXcd& strength,
                      const base::StopToken& stop = {}) const override;
    /// A point inside or on the body has no meaning.
    Eigen::VectorXcd scattered(const Eigen::Matrix3Xd& points,
                               const Eigen::VectorXcd& strength,
                               int threads = 1) const override;
    bool isInside(const Eigen::Vector3d& place) const override { return _body.isInside(place); }

private:
    void makeMatrix(int threads, const base::StopToken& stop);

    ClosedBody _body;
    double _k = 0.0;
    int _threads = 1;
    /// Transposed: column i is the equation at place i.
    Eigen::MatrixXcf _matrix;
};

} // namespace midair::haptics
