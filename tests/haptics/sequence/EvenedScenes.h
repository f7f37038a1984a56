#pragma once

#include "haptics/array/Medium.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/surface/ObjReader.h"
#include "haptics/surface/SurfaceSampler.h"
#include "tests/haptics/surface/SampleMeshes.h"

#include <Eigen/Core>

#include <cmath>
#include <complex>
#include <string>
#include <vector>

namespace midair::haptics
{

/// A mesh that cycles are evened out on, in the middle of the octagonal prism.
struct EvenedScene
{
    std::string name;
    TriangleMesh mesh;
    double spacing_m = 0.0; ///< between the points of one field
    Eigen::Matrix3Xd fine; ///< places on it where what is felt is measured, a fifth of a wave apart

    std::vector<ControlPoints> sets(int count) const
    {
        SamplerOptions sampling;
        sampling.spacing_m = spacing_m;
        std::vector<ControlPoints> sets;
        for (const SurfaceSamples& samples : sampleSurfaceSets(mesh, sampling, count))
        {
            ControlPoints& points = sets.emplace_back();
            points.positions = samples.positions;
            points.normals = samples.normals;
            points.targets = Eigen::VectorXd::Ones(samples.size());
        }
        return sets;
    }

    /// \a spacing: in wavelengths.
    ControlPoints places(const ControlPoints& points, double spacing = kPlaceSpacings.front()) const
    {
        SamplerOptions sampling;
        sampling.spacing_m = spacing * wavelength_m();
        return feltPlaces(sampleSurface(mesh, sampling).positions, points, kFeltReach * spacing_m);
    }

    static double wavelength_m() { return Medium().wavelength(40e3); }
};

/// \a isHeld: between the places at which a held field is evened out, which have this distance,
/// too.
inline Eigen::Matrix3Xd finePlaces(const TriangleMesh& mesh, bool isHeld = false)
{
    SamplerOptions sampling;
    sampling.spacing_m = 0.18 * EvenedScene::wavelength_m();
    sampling.maxPoints = 100000;
    return (isHeld ? sampleBetween(mesh, sampling) : sampleSurface(mesh, sampling)).positions;
}

/// The 30 mm sphere with about 100 points a field.
inline EvenedScene evenedSphere()
{
    EvenedScene scene{"sphere of 30 mm", test::sphere(0.03, 5), 9e-3, {}};
    scene.fine = finePlaces(scene.mesh);
    return scene;
}

/// The sample star, 80 mm wide, with points a wavelength apart. \a root: the project's folder.
inline EvenedScene evenedStar(const std::string& root)
{
    EvenedScene scene{"star of 80 mm",
                      readObj(root + "/samples/models/star.obj").scaledTo(0.08),
                      EvenedScene::wavelength_m(),
                      {}};
    scene.fine = finePlaces(scene.mesh);
    return scene;
}

/// Mean angle between the phases of \a a and \a b, once turned to be near, rad.
inline double meanTurn(const Eigen::VectorXcf& a, const Eigen::VectorXcf& b)
{
    const std::complex<float> common = std::polar(1.0f, std::arg(b.dot(a)));
    double sum = 0.0;
    for (Eigen::Index i = 0; i < a.size(); ++i)
        sum += std::fabs(static_cast<double>(std::arg(common * b[i] * std::conj(a[i]))));
    return sum / static_cast<double>(a.size());
}

/// \a scene, moved along x, as seen by a single field.
inline EvenedScene movedScene(EvenedScene scene, double x_m)
{
    scene.mesh.vertices.row(0).array() += x_m;
    scene.fine = finePlaces(scene.mesh, true);
    return scene;
}

} // namespace midair::haptics
