# scene.cmake - runs a shipped scene with few nodes for a few steps, and checks exit code, report and files.
#   cmake -D program=kith-2d -D scene=sod.yaml -D dimension=2 -D resolution=16 -D out=DIR -P scene.cmake
file(REMOVE_RECURSE ${out})
execute_process(
  COMMAND ${program} run ${scene} --set dimension=${dimension} --set resolution=${resolution}
    --set output.plot=false --check --steps 8 --quiet -o ${out}
  RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "exit code ${code}\n${text}")
endif()
file(READ ${out}/report.json report)
string(JSON steps GET ${report} steps)
string(JSON found GET ${report} dimension)
file(STRINGS ${scene} compared REGEX "^exact:")
if(compared)
  string(JSON density GET ${report} norms density l1)
endif()
string(JSON drift GET ${report} energy_drift)
if(NOT steps EQUAL 8 OR NOT found EQUAL dimension)
  message(FATAL_ERROR "report: ${steps} steps in ${found}-D")
endif()
foreach(file snapshot_0000.hdf snapshot_0001.hdf snapshots.hdf.series history.csv)
  if(NOT EXISTS ${out}/${file})
    message(FATAL_ERROR "no ${file}")
  endif()
endforeach()
