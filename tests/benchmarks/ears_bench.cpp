// What listening costs: the level at 32 places, and holding a field to a limit there; and by brute
// force whether any of many fields is over its limit.

#include "haptics/propagation/Exposure.h"
#include "tests/benchmarks/Timing.h"
#include "tests/engine-bridge/playing/EarTrials.h"

#include <cstdio>
#include <string>

using namespace midair;

namespace
{

Eigen::VectorXcf speckle(int transducers, std::mt19937& random)
{
    std::uniform_real_distribution<float> phase(0.0f, 6.28f);
    Eigen::VectorXcf q(transducers);
    for (std::complex<float>& one : q)
        one = std::polar(1.0f, phase(random));
    return q;
}

void time()
{
    const haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    const haptics::Medium medium;
    std::mt19937 random(1);
    const Eigen::VectorXcf q = speckle(array.size(), random);
    Eigen::Matrix3Xd places;
    std::printf("%d transducers, 32 places, one core, median\n", array.size());
    std::printf("choosing places       %8.3f ms\n",
                bench::median_ms(5, [&] { places = haptics::placesAround(array, 32); }));
    std::shared_ptr<haptics::Exposure> ears;
    std::printf("coefficients, once    %8.3f ms\n",
                bench::median_ms(
                    5, [&] { ears = std::make_shared<haptics::Exposure>(array, medium, places); }));
    double sum = 0.0;
    std::printf("incoherent, a field   %8.3f ms\n",
                bench::median_ms(1000, [&] { sum += ears->incoherent_Pa2(q).sum(); }));
    std::printf("with phases, a field  %8.3f ms\n",
                bench::median_ms(1000, [&] { sum += ears->coherent_Pa2(q).sum(); }));
    std::printf("spots, once           %8.3f ms\n",
                bench::median_ms(1, [&] { sum += ears->spots_Pa(q).cwiseAbs().sum(); }));
    std::printf("spots, a field        %8.3f ms\n",
                bench::median_ms(300, [&] { sum += ears->spots_Pa(q).cwiseAbs().sum(); }));
    const bridge::EarBound bound(110.0, ears);
    std::printf("limit, a field        %8.3f ms\n",
                bench::median_ms(300, [&] { sum += bound.excess(q, 0.0f, {}); }));
    std::printf("moving an ear         %8.3f ms\n",
                bench::median_ms(20, [&] { ears->move(3, places.col(3)); }));
    if (!(sum > 0.0)) std::printf("nothing is heard\n");
}

int bruteForce(int count)
{
    int over = 0;
    int held = 0;
    int silent = 0;
    double nearest_dB = -1e9;
    for (int done = 0; done < count;)
        for (const char* name : {"board", "ultraino64"})
        {
            EarTrials trials(
                haptics::TransducerArray::load(name), static_cast<unsigned int>(done + 1), 6);
            for (int k = 0; k < 50 && done < count; ++k, ++done)
            {
                const EarTrials::Outcome one = trials.next();
                over += one.loudest_dB > one.limit_dB ? 1 : 0;
                held += one.factor < 1.0 && one.factor > 0.0 ? 1 : 0;
                silent += one.factor <= 0.0 ? 1 : 0;
                nearest_dB = std::max(nearest_dB, one.loudest_dB - one.limit_dB);
            }
        }
    std::printf("%d drives by brute force: %d held down, %d silenced, %d over their limit; the "
                "nearest is %.3f dB from it\n",
                count,
                held,
                silent,
                over,
                -nearest_dB);
    return over == 0 ? 0 : 1;
}

} // namespace

int main(int argc, char** argv)
{
    time();
    return bruteForce(argc > 1 ? std::stoi(argv[1]) : 10000);
}
