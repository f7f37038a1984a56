/// Writes the recording samples/hands/star.csv anew: midair-star-hand > samples/hands/star.csv

#include "engine-bridge/hands/HandSource.h"
#include "tests/engine-bridge/hands/WrittenHands.h"
#include "tests/star-hand/StarHand.h"

#include <iostream>

int main()
{
    midair::bridge::writeHandRecording(std::cout, midair::tests::starHand());
    return std::cout.flush() ? 0 : 1;
}
