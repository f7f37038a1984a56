#pragma once

#include "haptics/scattering/ClosedBody.h"
#include "haptics/scattering/MatrixCache.h"
#include "haptics/scattering/Scatterer.h"

#include <Eigen/Geometry>

#include <functional>

namespace midair::haptics
{

/// How the matrix of a body is made.
struct BodyMaking
{
    int threads = 1; ///< >= 1
    base::StopToken stop = {};
    MatrixCache cache = {};                          ///< where it is looked for, and kept
    std::function<void(double share)> progress = {}; ///< 0 .. 1, of making it; on one thread
};

/// The field of a rigid closed body: the pressure on it, constant on each triangle, by the equation
/// of Burton and Miller (1971, 10.1098/rspa.1971.0097), which has one solution at all frequencies.
/// The matrix is dense, in single precision.
class RigidBody : public Scatterer
{
public:
    static constexpr double kElements = 6.0;             ///< an edge's wavelength over its length
    static constexpr double kResidual = 1e-4;            ///< of the equations
    static constexpr Eigen::Index kMostElements = 10000; ///< 0.8 GB

    /// Returns the error to expect, rms over the incident field, 3 mm off bodies of a wavelength
    /// and more, as measured on balls: 0.25 / \a elementsPerWavelength^2 (mean sides); 1 below 2.5,
    /// where nothing is right.
    static double expectedError(double elementsPerWavelength);

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

    /// Makes the matrix, or takes it from the cache.
    RigidBody(ClosedBody body, double wavelength_m, const BodyMaking& making);

    /// Moves the body, whose matrix stays as it is.
    void moveBy(const Eigen::Isometry3d& motion);

    /// Bytes that a body of \a elements takes, to be told beforehand.
    static double bytesFor(Eigen::Index elements);

    const ClosedBody& body() const { return _body; }
    const Eigen::Matrix3Xd& places() const override { return _body.centres; }
    const Eigen::Matrix3Xd& normals() const override { return _body.normals; }
    /// The strengths are the pressures on the body, Pa.
    GmresReport solve(const IncidentField& incident,
                      Eigen::VectorXcd& strength,
                      const base::StopToken& stop = {}) const override;
    /// 2 p of the transducers that the element faces, 0 otherwise, radiated by its double layer
    /// (Kirchhoff's approximation: Born, Wolf, Principles of Optics, 8.3). Rough where bodies are
    /// of the wavelength's size: half of what they scatter may be wrong.
    Eigen::MatrixXcf optics(const Eigen::Matrix3Xd& points,
                            const TransducerArray& array,
                            const Medium& medium,
                            int threads = 1,
                            const base::StopToken& stop = {}) const override;
    /// A point inside or on the body has no meaning.
    Eigen::VectorXcd scattered(const Eigen::Matrix3Xd& points,
                               const Eigen::VectorXcd& strength,
                               int threads = 1) const override;
    bool isInside(const Eigen::Vector3d& place) const override { return _body.isInside(place); }

private:
    void makeMatrix(const BodyMaking& making);
    std::complex<double> entryAt(Eigen::Index i, Eigen::Index j) const;
    std::complex<double> radiated(const Eigen::Vector3d& x, Eigen::Index j) const;

    ClosedBody _body;
    double _k = 0.0;
    int _threads = 1;
    /// Transposed: column i is the equation at place i.
    Eigen::MatrixXcf _matrix;
};

} // namespace midair::haptics
