// Questions about the paper's estimators that a sweep of the library's settings cannot answer, on the CPU.
#pragma once

#include "subject.hpp"

struct QuestionPlan {
    int width = 320, height = 180, stride = 2;
    int rays = 1024; // of the truth, a pixel
    uint32_t seed = 1;
};

// More layers or a minimum separation? One, two, three, four and eight exact layers, with and without separation.
// Where does the error come from? From rays over the hemisphere to the spiral's taps, an approximation at a time.
// Is the spiral a good pattern? Its number of turns swept, and other patterns at equal taps, one frame and sixteen averaged.
// Prints tables and adds lines to the CSV: scene,question,case,taps,ao_rmse,irradiance_rmse,irradiance_covered_rmse.
void answer_questions(const Subject& subject, const QuestionPlan& plan, std::FILE* csv);
