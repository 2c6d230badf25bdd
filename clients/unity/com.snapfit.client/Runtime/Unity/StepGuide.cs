using System;
using System.Threading;
using System.Threading.Tasks;
using UnityEngine;

namespace Snapfit.Unity
{
    /// <summary>Knows which step is to be taken now: asks for it whenever the assembly changes.
    /// <see cref="StepPanel"/> and <see cref="GhostDriver"/> show it.</summary>
    [AddComponentMenu("Snapfit/Step Guide")]
    [DefaultExecutionOrder(-50)]
    public sealed class StepGuide : MonoBehaviour
    {
        private const string Finished = "assembly-finished";
        private const float RetryS = 1;

        [SerializeField] private SnapfitConnection connection;

        private readonly Pending<StepAnswer> pending = new Pending<StepAnswer>();
        private string askedBootId;
        private long askedRevision;
        private bool isKnown;
        private double askedAtS = double.NegativeInfinity;
        private CancellationTokenSource ending;

        /// <summary>There is another step, or none any more.</summary>
        public event Action<Step> StepChanged;

        /// <summary>The connection that it asks.</summary>
        public SnapfitConnection Connection
        {
            get { return connection; }
            set { connection = value; }
        }

        /// <summary>The step that can be taken now; null where nothing is left to do, and until
        /// the server answered.</summary>
        public Step Current { get; private set; }

        /// <summary>Whether nothing is left to do.</summary>
        public bool IsFinished { get; private set; }

        /// <summary>Why there is no step, for people; null where there is one.</summary>
        public string Problem { get; private set; }

        private void OnEnable()
        {
            ending = new CancellationTokenSource();
            isKnown = false;
        }

        private void OnDisable()
        {
            ending.Cancel();
        }

        private void Update()
        {
            StepAnswer answer;
            Exception error;
            if (pending.TryTake(out answer, out error))
            {
                Take(answer, error);
            }
            PoseSnapshot latest = connection == null ? null : connection.Latest;
            if (latest == null || !latest.HasAssembly || connection.Client == null)
            {
                return;
            }
            bool isNew = latest.BootId != askedBootId
                || latest.Assembly.Revision != askedRevision;
            bool isRetry = !isKnown && Time.unscaledTimeAsDouble - askedAtS >= RetryS;
            if ((isNew || isRetry) && !pending.IsBusy)
            {
                askedBootId = latest.BootId;
                askedRevision = latest.Assembly.Revision;
                askedAtS = Time.unscaledTimeAsDouble;
                Task<StepAnswer> request = connection.Client.GetCurrentStepAsync(ending.Token);
                pending.Begin(request);
            }
        }

        private void Take(StepAnswer answer, Exception error)
        {
            ProblemException problem = error as ProblemException;
            IsFinished = problem != null && problem.Kind == Finished;
            isKnown = error == null || IsFinished;
            Problem = isKnown ? null : error.Message;
            Step next = answer == null ? null : answer.Step;
            if (isKnown || problem != null)
            {
                Current = next;
                StepChanged?.Invoke(next);
            }
        }
    }
}
