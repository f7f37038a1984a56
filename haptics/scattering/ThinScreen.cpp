#include "haptics/scattering/ThinScreen.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/scattering/Kernels.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <unsupported/Eigen/FFT>

namespace midair::haptics
{

namespace
{

using scattering::Complex;

constexpr double kLatticeResidual = 1e-4;
constexpr int kLatticeIterations = 500;

// Gauss-Legendre on -1/2 .. 1/2; weights of each sum up to 1.
struct GaussPoint
{
    double at, weight;
};
constexpr std::array<GaussPoint, 2> kGauss2 = {
    {{-0.28867513459481287, 0.5}, {0.28867513459481287, 0.5}}};
constexpr std::array<GaussPoint, 8> kGauss8 = {{{-0.48014492824876811, 0.050614268145188130},
                                                {-0.39833323870681337, 0.11119051722668724},
                                                {-0.26276620495816449, 0.15685332293894364},
                                                {-0.091717321247824950, 0.18134189168918099},
                                                {0.091717321247824950, 0.18134189168918099},
                                                {0.26276620495816449, 0.15685332293894364},
                                                {0.39833323870681337, 0.11119051722668724},
                                                {0.48014492824876811, 0.050614268145188130}}};

/// The integral of \a f over a cell of 1 x 1 round the origin.
template<typename Rule, typename Function>
Complex overCell(const Rule& rule, Function&& f)
{
    Complex sum = 0.0;
    for (const GaussPoint& u : rule)
        for (const GaussPoint& v : rule)
            sum += u.weight * v.weight * f(u.at, v.at);
    return sum;
}

/// The normal derivative at the origin of the double layer of a cell of \a size round \a centre,
/// both in the plane: k^2 int G dS + contour dG/dnu dl.
template<typename Rule>
Complex
entry(double k, const Eigen::Vector2d& centre, const Eigen::Vector2d& size, const Rule& rule)
{
    const bool isSelf = centre == Eigen::Vector2d::Zero();
    Complex surface = overCell(rule,
                               [&](double u, double v)
                               {
                                   const double r = std::hypot(centre.x() + u * size.x(),
                                                               centre.y() + v * size.y());
                                   const Complex G = scattering::green(k, r);
                                   return isSelf ? G - scattering::kInverse4Pi / r : G;
                               }) *
                      size.prod();
    if (isSelf)
        surface += 2.0 * scattering::kInverse4Pi *
                   (size.x() * std::asinh(size.y() / size.x()) +
                    size.y() * std::asinh(size.x() / size.y()));
    Complex contour = 0.0;
    for (const int axis : {0, 1})
        for (const double side : {-0.5, 0.5})
        {
            const double d = centre[axis] + side * size[axis];
            for (const GaussPoint& t : rule)
            {
                const double r = std::hypot(d, centre[1 - axis] + t.at * size[1 - axis]);
                contour -= (side > 0.0 ? d : -d) * t.weight * size[1 - axis] * Complex(1.0 / r, k) *
                           scattering::green(k, r) / r;
            }
        }
    return k * k * surface + contour;
}

/// The smallest number from \a least on that has no prime factor over 5.
Eigen::Index goodSize(Eigen::Index least)
{
    for (Eigen::Index size = least;; ++size)
    {
        Eigen::Index rest = size;
        for (const Eigen::Index prime : {2, 3, 5})
            while (rest % prime == 0)
                rest /= prime;
        if (rest == 1) return size;
    }
}

} // namespace

/// The matrix of the lattice, applied by transforms.
class ThinScreen::Toeplitz
{
public:
    Toeplitz(double k, Eigen::Index columns, Eigen::Index rows, const Eigen::Vector2d& cell_m) :
        _columns(columns),
        _rows(rows),
        _lattice(Eigen::MatrixXcd::Zero(goodSize(2 * columns - 1), goodSize(2 * rows - 1)))
    {
        for (Eigen::Index j = 0; j < rows; ++j)
            for (Eigen::Index i = 0; i < columns; ++i)
            {
                const Eigen::Vector2d centre = cell_m.cwiseProduct(
                    Eigen::Vector2d(static_cast<double>(i), static_cast<double>(j)));
                const Complex one = std::max(i, j) <= kNear ? entry(k, centre, cell_m, kGauss8)
                                                            : entry(k, centre, cell_m, kGauss2);
                for (const Eigen::Index column : {i, (_lattice.rows() - i) % _lattice.rows()})
                    for (const Eigen::Index row : {j, (_lattice.cols() - j) % _lattice.cols()})
                        _lattice(column, row) = one;
            }
        _spectrum = forward(_lattice, _lattice.cols());
    }

    void apply(const Eigen::VectorXcd& x, Eigen::VectorXcd& y)
    {
        _lattice.setZero();
        _lattice.topLeftCorner(_columns, _rows) =
            Eigen::Map<const Eigen::MatrixXcd>(x.data(), _columns, _rows);
        const Eigen::MatrixXcd product = forward(_lattice, _rows).cwiseProduct(_spectrum);
        Eigen::MatrixXcd back(product.cols(), product.rows());
        Eigen::VectorXcd line(product.rows());
        for (Eigen::Index c = 0; c < product.cols(); ++c)
        {
            _transform.inv(line.data(), product.col(c).data(), product.rows());
            back.row(c) = line.transpose();
        }
        y.resize(_columns * _rows);
        line.resize(back.rows());
        for (Eigen::Index row = 0; row < _rows; ++row)
        {
            _transform.inv(line.data(), back.col(row).data(), back.rows());
            y.segment(row * _columns, _columns) = line.head(_columns);
        }
    }

private:
    static constexpr Eigen::Index kNear = 4; // cells within which G isn't smooth

    /// Returns the transform of \a lattice, transposed; only the first \a used columns aren't zero.
    Eigen::MatrixXcd forward(const Eigen::MatrixXcd& lattice, Eigen::Index used)
    {
        Eigen::MatrixXcd turned = Eigen::MatrixXcd::Zero(lattice.cols(), lattice.rows());
        Eigen::VectorXcd line(lattice.rows());
        for (Eigen::Index c = 0; c < used; ++c)
        {
            _transform.fwd(line.data(), lattice.col(c).data(), lattice.rows());
            turned.row(c) = line.transpose();
        }
        line.resize(turned.rows());
        for (Eigen::Index c = 0; c < turned.cols(); ++c)
        {
            _transform.fwd(line.data(), turned.col(c).data(), turned.rows());
            turned.col(c) = line;
        }
        return turned;
    }

    Eigen::Index _columns;
    Eigen::Index _rows;
    Eigen::MatrixXcd _lattice; ///< padded; scratch after the constructor
    Eigen::MatrixXcd _spectrum;
    Eigen::FFT<double> _transform;
};

std::optional<ScreenPlate> plateOf(const Reflector& reflector)
{
    if (reflector.reflection != 1.0 || reflector.reflectionPhase_rad != 0.0 ||
        !reflector.size_m.allFinite() || reflector.isBoard)
        return std::nullopt;
    return ScreenPlate{reflector.position, reflector.normal, reflector.along, reflector.size_m};
}

ThinScreen::ThinScreen(const ScreenPlate& plate, double wavelength_m, double cellsPerWavelength) :
    _plate(plate),
    _k(base::kTwoPi / wavelength_m)
{
    if (!plate.centre.allFinite() || !plate.size_m.allFinite() || !(plate.size_m.minCoeff() > 0.0))
        throw base::InputError("a screen needs a finite centre and a size above 0");
    const Eigen::Array2d counts = cellsOf(plate, wavelength_m, cellsPerWavelength);
    if (!(counts.prod() <= static_cast<double>(kMostCells)))
        throw base::InputError(
            fmt::format("a screen of {:g} x {:g} m has {:.0f} cells; at most {} are possible",
                        plate.size_m.x(),
                        plate.size_m.y(),
                        counts.prod(),
                        kMostCells));
    const auto columns = static_cast<Eigen::Index>(counts.x());
    const auto rows = static_cast<Eigen::Index>(counts.y());
    _cell_m = plate.size_m.array() / (counts + 0.5);
    const Eigen::Vector3d across = plate.normal.cross(plate.along);
    _places.resize(3, columns * rows);
    for (Eigen::Index j = 0; j < rows; ++j)
        for (Eigen::Index i = 0; i < columns; ++i)
            _places.col(j * columns + i) =
                plate.centre +
                _cell_m.x() * (static_cast<double>(i) - 0.5 * (counts.x() - 1.0)) * plate.along +
                _cell_m.y() * (static_cast<double>(j) - 0.5 * (counts.y() - 1.0)) * across;
    _normals = plate.normal.replicate(1, columns * rows);
    _matrix = std::make_unique<Toeplitz>(_k, columns, rows, _cell_m);
}

ThinScreen::~ThinScreen() = default;

// N cells and half a cell make up a side.
Eigen::Array2d
ThinScreen::cellsOf(const ScreenPlate& plate, double wavelength_m, double cellsPerWavelength)
{
    return (plate.size_m.array() * cellsPerWavelength / wavelength_m - 0.5).ceil().max(1.0);
}

GmresReport ThinScreen::solve(const IncidentField& incident,
                              Eigen::VectorXcd& strength,
                              const base::StopToken& stop) const
{
    return gmres([this](const Eigen::VectorXcd& x, Eigen::VectorXcd& y) { _matrix->apply(x, y); },
                 -incident.slope_Pa_m,
                 strength,
                 kLatticeResidual,
                 kLatticeIterations,
                 stop);
}

Eigen::VectorXcd ThinScreen::scattered(const Eigen::Matrix3Xd& points,
                                       const Eigen::VectorXcd& strength,
                                       int threads) const
{
    const Eigen::Vector3d u = _cell_m.x() * _plate.along;
    const Eigen::Vector3d v = _cell_m.y() * _plate.normal.cross(_plate.along);
    const double size_m = _cell_m.maxCoeff(), area_m2 = _cell_m.prod();
    const auto ofCell = [&](const Eigen::Vector3d& d)
    {
        const auto at = [&](double s, double t)
        { return scattering::greenSlope(_k, d - s * u - t * v, _plate.normal); };
        const double ratio = d.norm() / size_m;
        if (ratio > 3.0) return overCell(kGauss2, at);
        if (ratio > 1.0) return overCell(kGauss8, at);
        // Quarters of quarters: the point may be a tenth of a cell away.
        Complex sum = 0.0;
        for (int a = 0; a < 8; ++a)
            for (int b = 0; b < 8; ++b)
                sum += overCell(kGauss8,
                                [&](double s, double t)
                                { return at((a + 0.5 + s) / 8 - 0.5, (b + 0.5 + t) / 8 - 0.5); });
        return sum / 64.0;
    };
    return scattering::atEach(points,
                              threads,
                              [&](const Eigen::Vector3d& x)
                              {
                                  Complex sum = 0.0;
                                  for (Eigen::Index i = 0; i < _places.cols(); ++i)
                                      sum += strength[i] * ofCell(x - _places.col(i));
                                  return area_m2 * sum;
                              });
}

} // namespace midair::haptics
