#pragma once

#include "haptics/array/Reflector.h"
#include "haptics/scattering/Scatterer.h"

#include <memory>
#include <optional>

namespace midair::haptics
{

/// A rectangular plate without thickness.
struct ScreenPlate
{
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< metres
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ(); ///< unit length, of either side
    Eigen::Vector3d along = Eigen::Vector3d::UnitX();  ///< unit length, in the plate
    Eigen::Vector2d size_m = Eigen::Vector2d::Zero();  ///< along it, and across
};

/// Returns the plate of \a reflector, if that is rigid and has ends.
std::optional<ScreenPlate> plateOf(const Reflector& reflector);

/// The field of a rigid plate: the jump of the pressure across it, constant on each cell, such that
/// no air moves through the cells' centres (Maue 1949, 10.1007/BF01328780). The matrix of a regular
/// lattice is block Toeplitz, so that an iteration is two transforms. The lattice ends a quarter of
/// a cell before the edges (Hough 1973, 10.2514/3.44450), where the jump is zero.
class ThinScreen : public Scatterer
{
public:
    /// Most cells; one takes about 0.5 kB.
    static constexpr Eigen::Index kMostCells = 250000;

    /// \a wavelength_m > 0; \a cellsPerWavelength: 8 give 0.4 % of the scattered field, 12 0.2 %.
    /// Throws InputError for a plate that isn't finite, has no area, or has more than kMostCells.
    ThinScreen(const ScreenPlate& plate, double wavelength_m, double cellsPerWavelength = 8.0);
    ~ThinScreen() override;

    /// Returns the number of cells along a plate and across, whole numbers >= 1.
    static Eigen::Array2d
    cellsOf(const ScreenPlate& plate, double wavelength_m, double cellsPerWavelength = 8.0);

    const Eigen::Matrix3Xd& places() const override { return _places; }
    const Eigen::Matrix3Xd& normals() const override { return _normals; }
    /// The strengths are the jumps of the pressure, Pa: that on the normal's side minus the other.
    GmresReport solve(const IncidentField& incident,
                      Eigen::VectorXcd& strength,
                      const base::StopToken& stop = {}) const override;
    Eigen::VectorXcd scattered(const Eigen::Matrix3Xd& points,
                               const Eigen::VectorXcd& strength,
                               int threads = 1) const override;

private:
    class Toeplitz;

    ScreenPlate _plate;
    double _k = 0.0;
    Eigen::Vector2d _cell_m = Eigen::Vector2d::Zero();
    Eigen::Matrix3Xd _places;
    Eigen::Matrix3Xd _normals;
    std::unique_ptr<Toeplitz> _matrix;
};

} // namespace midair::haptics
