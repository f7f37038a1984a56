#include "haptics/scattering/RigidBody.h"

#include "haptics/base/Units.h"
#include "haptics/base/threads/ThreadPool.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/scattering/Kernels.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

namespace midair::haptics
{

namespace
{

using scattering::Complex;
using Corners = std::array<Eigen::Vector3d, 3>;

constexpr int kMostIterations = 500;

/// A rule on a triangle (Dunavant 1985, 10.1002/nme.1620210612): barycentric coordinates and
/// weights that sum up to 1.
struct TrianglePoint
{
    double a, b, c, weight;
};
constexpr std::array<TrianglePoint, 3> kRule3 = {{{2.0 / 3, 1.0 / 6, 1.0 / 6, 1.0 / 3},
                                                  {1.0 / 6, 2.0 / 3, 1.0 / 6, 1.0 / 3},
                                                  {1.0 / 6, 1.0 / 6, 2.0 / 3, 1.0 / 3}}};
constexpr double kOuter = 0.797426985353087, kOuterSide = 0.101286507323456,
                 kOuterWeight = 0.125939180544827;
constexpr double kInner = 0.059715871789770, kInnerSide = 0.470142064105115,
                 kInnerWeight = 0.132394152788506;
constexpr std::array<TrianglePoint, 7> kRule7 = {{{1.0 / 3, 1.0 / 3, 1.0 / 3, 0.225},
                                                  {kOuter, kOuterSide, kOuterSide, kOuterWeight},
                                                  {kOuterSide, kOuter, kOuterSide, kOuterWeight},
                                                  {kOuterSide, kOuterSide, kOuter, kOuterWeight},
                                                  {kInner, kInnerSide, kInnerSide, kInnerWeight},
                                                  {kInnerSide, kInner, kInnerSide, kInnerWeight},
                                                  {kInnerSide, kInnerSide, kInner, kInnerWeight}}};

template<typename Rule, typename Function>
Complex overTriangle(const Rule& rule, const Corners& t, double area, Function&& f)
{
    Complex sum = 0.0;
    for (const TrianglePoint& at : rule)
        sum += at.weight * f(Eigen::Vector3d(at.a * t[0] + at.b * t[1] + at.c * t[2]));
    return area * sum;
}

/// The integral of \a f, which isn't smooth at \a x, over a triangle at some distance from it.
template<typename Function>
Complex
integral(const Eigen::Vector3d& x, const Corners& t, double area, int most, const Function& f)
{
    const double size = std::sqrt(area);
    const double ratio = ((t[0] + t[1] + t[2]) / 3.0 - x).norm() / size;
    if (ratio > 4.0) return overTriangle(kRule3, t, area, f);
    if (ratio > 2.0 || most == 0) return overTriangle(kRule7, t, area, f);
    const Eigen::Vector3d ab = 0.5 * (t[0] + t[1]), bc = 0.5 * (t[1] + t[2]),
                          ca = 0.5 * (t[2] + t[0]);
    Complex sum = 0.0;
    for (const Corners& part :
         {Corners{t[0], ab, ca}, Corners{ab, t[1], bc}, Corners{ca, bc, t[2]}, Corners{ab, bc, ca}})
        sum += integral(x, part, 0.25 * area, most - 1, f);
    return sum;
}

constexpr int kDivisions = 5;

/// -1/(4 pi) contour e^{-jkR}/R dtheta - jk/2: the second derivative of a triangle's double layer
/// at its own centre.
Complex ownSecond(double k, const Eigen::Vector3d& centre, const Corners& t)
{
    Complex contour = 0.0;
    for (int edge = 0; edge < 3; ++edge)
    {
        const Eigen::Vector3d a = t[static_cast<std::size_t>(edge)] - centre,
                              b = t[static_cast<std::size_t>((edge + 1) % 3)] - centre;
        // R = distance / cos(theta) from the foot of the perpendicular.
        const Eigen::Vector3d along = (b - a).normalized();
        const double distance = (a - a.dot(along) * along).norm();
        const double from = std::atan2(a.dot(along), distance),
                     to = std::atan2(b.dot(along), distance);
        constexpr int kSteps = 16; // midpoints; the integrand is smooth
        for (int step = 0; step < kSteps; ++step)
        {
            const double theta = from + (to - from) * (step + 0.5) / kSteps;
            const double R = distance / std::cos(theta);
            contour += std::polar((to - from) / kSteps / R, -k * R);
        }
    }
    return -scattering::kInverse4Pi * contour - Complex(0.0, 0.5 * k);
}

} // namespace

double RigidBody::expectedError(double elementsPerWavelength)
{
    constexpr double kLeast = 2.5;
    return elementsPerWavelength < kLeast ? 1.0 : 0.25 / std::pow(elementsPerWavelength, 2);
}

ClosedBody
RigidBody::divided(const TriangleMesh& mesh, double wavelength_m, double elementsPerWavelength)
{
    return ClosedBody::from(mesh, wavelength_m / elementsPerWavelength, kMostElements);
}

RigidBody::RigidBody(ClosedBody body,
                     double wavelength_m,
                     int threads,
                     const base::StopToken& stop) :
    RigidBody(std::move(body), wavelength_m, BodyMaking{threads, stop})
{
}

RigidBody::RigidBody(ClosedBody body, double wavelength_m, const BodyMaking& making) :
    _body(std::move(body)),
    _k(base::kTwoPi / wavelength_m),
    _threads(making.threads)
{
    const std::filesystem::path file = making.cache.fileFor(_body, wavelength_m);
    if (making.cache.read(file, _body.size(), _matrix)) return;
    const auto begin = std::chrono::steady_clock::now();
    makeMatrix(making);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    if (took.count() >= making.cache.leastMaking_s) making.cache.write(file, _matrix);
}

void RigidBody::moveBy(const Eigen::Isometry3d& motion)
{
    _body.corners = motion * _body.corners;
    _body.centres = motion * _body.centres;
    _body.normals = motion.linear() * _body.normals;
}

double RigidBody::bytesFor(Eigen::Index elements)
{
    const auto n = static_cast<double>(elements);
    return n * n * sizeof(std::complex<float>) + 100.0 * n * sizeof(Complex);
}

// p/2 - int p dG/dn_y - alpha int p d2G/dn_x dn_y = p_inc + alpha dp_inc/dn, alpha = -j/k.
Complex RigidBody::entryAt(Eigen::Index i, Eigen::Index j) const
{
    const Complex alpha(0.0, -1.0 / _k);
    const Eigen::Vector3d x = _body.centres.col(i), nx = _body.normals.col(i),
                          ny = _body.normals.col(j);
    const Corners t{
        _body.corners.col(3 * j), _body.corners.col(3 * j + 1), _body.corners.col(3 * j + 2)};
    if (i == j) return 0.5 - alpha * ownSecond(_k, x, t);
    const double cosine = nx.dot(ny);
    return -integral(x,
                     t,
                     _body.areas[j],
                     kDivisions,
                     [&](const Eigen::Vector3d& y) -> Complex
                     {
                         const Eigen::Vector3d d = x - y;
                         const double r2 = d.squaredNorm(), r = std::sqrt(r2), inverse = 1.0 / r;
                         const Complex G = scattering::green(_k, r);
                         const double dx = d.dot(nx) * inverse, dy = d.dot(ny) * inverse;
                         const Complex first = Complex(inverse, _k) * G;
                         const Complex second =
                             first * inverse * cosine +
                             (_k * _k - 3.0 * inverse * Complex(inverse, _k)) * G * dx * dy;
                         return first * dy + alpha * second;
                     });
}

void RigidBody::makeMatrix(const BodyMaking& making)
{
    const Eigen::Index n = _body.size();
    _matrix.resize(n, n);
    std::atomic<Eigen::Index> done{0};
    base::ThreadPool pool(making.threads);
    pool.run(
        [&](int thread)
        {
            for (Eigen::Index i = thread; i < n && !making.stop.requested(); i += making.threads)
            {
                for (Eigen::Index j = 0; j < n; ++j)
                    _matrix(j, i) = std::complex<float>(entryAt(i, j));
                const auto rows = static_cast<double>(++done);
                if (thread == 0 && making.progress) making.progress(rows / static_cast<double>(n));
            }
        });
    making.stop.throwIfRequested();
}

GmresReport RigidBody::solve(const IncidentField& incident,
                             Eigen::VectorXcd& strength,
                             const base::StopToken& stop) const
{
    const Complex alpha(0.0, -1.0 / _k);
    base::ThreadPool pool(_threads);
    const ComplexOperator apply = [&](const Eigen::VectorXcd& x, Eigen::VectorXcd& y)
    {
        const Eigen::VectorXcf in = x.cast<std::complex<float>>();
        const Eigen::Index n = in.size();
        pool.run(
            [&](int thread)
            {
                const Eigen::Index from = n * thread / _threads, to = n * (thread + 1) / _threads;
                y.segment(from, to - from) =
                    (_matrix.middleCols(from, to - from).transpose() * in).cast<Complex>();
            });
    };
    return gmres(apply,
                 incident.pressure_Pa + alpha * incident.slope_Pa_m,
                 strength,
                 kResidual,
                 kMostIterations,
                 stop);
}

Complex RigidBody::radiated(const Eigen::Vector3d& x, Eigen::Index j) const
{
    const Eigen::Vector3d normal = _body.normals.col(j);
    return integral(
        x,
        {_body.corners.col(3 * j), _body.corners.col(3 * j + 1), _body.corners.col(3 * j + 2)},
        _body.areas[j],
        kDivisions,
        [&](const Eigen::Vector3d& y) { return scattering::greenSlope(_k, x - y, normal); });
}

Eigen::VectorXcd RigidBody::scattered(const Eigen::Matrix3Xd& points,
                                      const Eigen::VectorXcd& strength,
                                      int threads) const
{
    return scattering::atEach(points,
                              threads,
                              [&](const Eigen::Vector3d& x)
                              {
                                  Complex sum = 0.0;
                                  for (Eigen::Index j = 0; j < _body.size(); ++j)
                                      sum += strength[j] * radiated(x, j);
                                  return sum;
                              });
}

// A product of what blocks of elements radiate to the points and what reaches these elements.
Eigen::MatrixXcf RigidBody::optics(const Eigen::Matrix3Xd& points,
                                   const TransducerArray& array,
                                   const Medium& medium,
                                   int threads,
                                   const base::StopToken& stop) const
{
    constexpr Eigen::Index kBlock = 256; // elements whose rows take some megabytes
    const Eigen::Index n = _body.size(), blocks = (n + kBlock - 1) / kBlock;
    std::vector<Eigen::MatrixXcf> sums(static_cast<std::size_t>(threads));
    base::ThreadPool pool(threads);
    pool.run(
        [&](int thread)
        {
            Eigen::MatrixXcf& sum = sums[static_cast<std::size_t>(thread)];
            sum.setZero(points.cols(), array.size());
            for (Eigen::Index block = thread; block < blocks && !stop.requested(); block += threads)
            {
                const Eigen::Index first = kBlock * block, count = std::min(kBlock, n - first);
                Eigen::MatrixXcf in =
                    2.0f * referencePropagationMatrix(
                               _body.centres.middleCols(first, count), array, medium)
                               .cast<std::complex<float>>();
                Eigen::MatrixXcf out(points.cols(), count);
                for (Eigen::Index j = 0; j < count; ++j)
                {
                    const Eigen::Vector3d centre = _body.centres.col(first + j),
                                          normal = _body.normals.col(first + j);
                    for (Eigen::Index i = 0; i < in.cols(); ++i)
                        if (!(normal.dot(array.positions.col(i) - centre) > 0.0)) in(j, i) = 0.0f;
                    for (Eigen::Index l = 0; l < points.cols(); ++l)
                        out(l, j) = std::complex<float>(radiated(points.col(l), first + j));
                }
                sum.noalias() += out * in;
            }
        });
    stop.throwIfRequested();
    for (std::size_t thread = 1; thread < sums.size(); ++thread)
        sums.front() += sums[thread];
    return sums.front();
}

} // namespace midair::haptics
